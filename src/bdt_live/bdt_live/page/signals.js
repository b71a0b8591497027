// Rows of the loop's signals, in columns that plots can draw without a copy.

export const COLUMNS = [
  "time", "voltage_first", "voltage_second", "position_first", "position_second", "position",
  "theta_m", "theta_d", "gap", "q1", "q2", "reference", "dead_zone", "estimate", "uncertainty",
];

const HELD = new Set(["reference", "estimate", "uncertainty"]); // from row to row
const NEWEST = new Set(["gap", "dead_zone"]); // what somebody sets, who waits to see it

const KEPT = 12000; // rows: two minutes
const BUCKET = 0.01; // s, of a row
const LEAST_LAG = 0.04; // s of wall time by which what is shown is behind the newest row
const MOST_LAG = 0.25;

export class Signals {
  constructor() {
    this.columns = Object.fromEntries(COLUMNS.map((name) => [name, new Float64Array(2 * KEPT)]));
    this.clear();
  }

  clear() {
    this.begin = 0;
    this.end = 0;
    this.shown = null; // time that the page shows
    this.rate = 1; // simulated seconds in a second, as they come
    this.lag = LEAST_LAG; // s, as long as the waits for rows of late
    this.arrivals = [];
  }

  get size() { return this.end - this.begin; }

  // The newest time [s]; null while there is none.
  get newest() { return this.size ? this.columns.time[this.end - 1] : null; }

  add(rows) {
    for (const row of rows) {
      if (this.size && row[0] < this.newest) this.clear(); // time has begun anew
      if (this.size && row[0] === this.newest) continue;
      if (this.end === 2 * KEPT) this.moveToFront();
      COLUMNS.forEach((name, index) => {
        this.columns[name][this.end] = row[index] ?? NaN;
      });
      this.end += 1;
      if (this.size > KEPT) this.begin += 1;
    }
  }

  moveToFront() {
    for (const column of Object.values(this.columns)) column.copyWithin(0, this.begin, this.end);
    this.end -= this.begin;
    this.begin = 0;
  }

  // Note that rows have come at a wall time [s], for the rate at which time goes on.
  noteArrival(now) {
    this.arrivals.push([now, this.newest]);
    while (this.arrivals.length > 2 && now - this.arrivals[0][0] > 1) this.arrivals.shift();
    const waits = this.arrivals.slice(1).map(([at], index) => at - this.arrivals[index][0]);
    // One wait in ten may be longer: time then stands still for a moment.
    const usual = waits.sort((a, b) => a - b)[Math.floor(0.9 * waits.length)] ?? 0;
    const wanted = Math.min(Math.max(LEAST_LAG, 1.2 * usual), MOST_LAG);
    this.lag = Math.max(wanted, 0.98 * this.lag);
    const [begin, time] = this.arrivals[0];
    if (now - begin > 0.2) this.rate = Math.max((this.newest - time) / (now - begin), 0);
  }

  // Let what is shown go on by a time on the wall [s], evenly although rows come in batches.
  advance(elapsed) {
    if (this.newest === null) return;
    const goal = this.newest - this.lag * this.rate;
    const off = this.shown === null ? Infinity : goal - this.shown;
    if (Math.abs(off) > 0.5 * Math.max(this.rate, 0.2)) {
      this.shown = goal;
    } else {
      this.shown += Math.max(elapsed * this.rate + off * Math.min(3 * elapsed, 1), 0);
    }
    this.shown = Math.min(this.shown, this.newest);
  }

  // Index of the last row at or before a time.
  indexAt(time) {
    let low = this.begin;
    let high = this.end;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.columns.time[middle] <= time) low = middle + 1; else high = middle;
    }
    return low - 1;
  }

  // Values of the time that is shown, between two rows by a straight line; NEWEST of the newest
  // row.
  now() {
    const before = this.indexAt(this.shown ?? 0);
    if (before < this.begin) return null;
    const after = Math.min(before + 1, this.end - 1);
    const span = this.columns.time[after] - this.columns.time[before];
    const share = span > 0 && span < 5 * BUCKET ? (this.shown - this.columns.time[before]) / span : 0;
    return Object.fromEntries(COLUMNS.map((name) => {
      const column = this.columns[name];
      if (NEWEST.has(name)) return [name, column[this.end - 1]];
      const value = column[before];
      return [name, HELD.has(name) ? value : value + share * (column[after] - value)];
    }));
  }
}
