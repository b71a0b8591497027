/* The closed loop of bdt_bringup/closed_loop.py in plain C, as fast as a compiler makes it: the
 * yardstick of `bdt bench kernel_vs_c`. Written by hand from the same equations (numbers of the
 * paper), with coefficients and inputs handed in, so that only the loop is compared.
 *
 * cc -O3 -march=native -ffast-math -fPIC -c closed_loop.c
 * cc -shared -o closed_loop.so closed_loop.o -lm
 */
#include <math.h>

#define SMALLEST_SIGNAL 1e-30

/* Motor (eq. 2): i, omega_m, theta_m from (i, omega_m, u). */
typedef struct { double current[3], speed[3], angle[3]; } motor_step;
/* Structure (eq. 3): q2, q2', q3, q3' from (q2, q2', q3, q3', d before, d after). */
typedef struct { double row[4][6]; } structure_step;
/* The motor's curved path in contact: the same four from (i, omega_m, u). */
typedef struct { double row[4][3]; } contact_step;

typedef struct {
    motor_step motor;
    structure_step structure;
    contact_step contact;
    double pitch;
    double proportional, integral, derivative, period, decay; /* PID (eqs 4, 5) */
} discrete_loop;

void closed_loop(const discrete_loop *step, long contact, long control_steps, long hold,
                 const double *restrict references, const double *restrict tolerances,
                 const double *restrict gaps, double *restrict u, double *restrict theta_m,
                 double *restrict theta_d, double *restrict q3)
{
    const discrete_loop s = *step;
    double current = 0, speed = 0, angle = 0, screw = 0, x[4] = {0, 0, 0, 0};
    double integral = 0, filtered = 0;
    long sample = 0;

    for (long k = 0; k < control_steps; k++) {
        /* Dead-zone PID (eqs 4, 5, 7, 8). */
        const double error = references[k] - x[2], tolerance = tolerances[k];
        const double e = fabs(error) > tolerance ? error : 0.0;
        integral += s.period * e;
        filtered = s.decay * filtered + (1.0 - s.decay) * e;
        if (fabs(filtered) < SMALLEST_SIGNAL) filtered = 0.0;
        double voltage = s.proportional * e + s.integral * integral
                       + s.derivative * (e - filtered);
        if (tolerance > 0.0 && fabs(error) <= tolerance) voltage = 0.0;

        for (const long end = sample + hold; sample < end; sample++) {
            u[sample] = voltage;
            theta_m[sample] = angle;
            theta_d[sample] = screw;
            q3[sample] = x[2];

            const motor_step *m = &s.motor;
            double i = m->current[0] * current + m->current[1] * speed + m->current[2] * voltage;
            double w = m->speed[0] * current + m->speed[1] * speed + m->speed[2] * voltage;
            const double next_angle = angle
                + (m->angle[0] * current + m->angle[1] * speed + m->angle[2] * voltage);
            if (fabs(i) < SMALLEST_SIGNAL) i = 0.0;
            if (fabs(w) < SMALLEST_SIGNAL) w = 0.0;

            /* Backlash (eq. 6), lead screw (eq. 1). */
            const double half = 0.5 * gaps[sample];
            const double low = next_angle - half, high = next_angle + half;
            const double next_screw = fmin(fmax(screw, low), high);
            const long next_contact = next_screw == low ? 1 : next_screw == high ? -1 : 0;
            const double before = s.pitch * screw, after = s.pitch * next_screw;

            double y[4];
            for (int n = 0; n < 4; n++) {
                const double *a = s.structure.row[n];
                y[n] = a[0] * x[0] + a[1] * x[1] + a[2] * x[2] + a[3] * x[3]
                     + a[4] * before + a[5] * after;
            }
            if (next_contact != 0 && next_contact == contact)
                for (int n = 0; n < 4; n++) {
                    const double *a = s.contact.row[n];
                    y[n] += a[0] * current + a[1] * speed + a[2] * voltage;
                }
            for (int n = 0; n < 4; n++) x[n] = y[n];
            current = i, speed = w, angle = next_angle, screw = next_screw;
            contact = next_contact;
        }
    }
}
