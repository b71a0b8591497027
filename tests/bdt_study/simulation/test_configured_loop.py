"""Loops as the nodes' parameters describe them: the values arrive where the nodes have them."""

import pytest

from bdt_controller.pid import PidGains
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_study.simulation.configured_loop import LoopParameters, part_of, simulate_setup
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import tolerance_for_gap
from bdt_twin.estimator import Estimate

PITCH = LeadScrewParameters().pitch
VALUES = {
    "plant": {"gap.kind": "constant", "gap.initial": 0.2, "telemetry_period": 0.2},
    "controller": {"reference.step_time": 2.0, "pid.integral": 20000.0, "voltage_limit": 24.0},
    "twin": {
        "communication_delay": 0.0,
        "lead_screw.pitch": 2.0 * PITCH,
        "redesign.integral": 25000.0,
    },
}


@pytest.fixture(scope="module")
def parameters():
    return LoopParameters.from_values(VALUES)


def test_values_of_each_node_arrive_in_its_part_of_the_loop(parameters):
    scenario, twin = parameters.scenario(6.0), parameters.twin()
    assert scenario.gap == GapProfile("constant", 0.2)
    assert scenario.gains == PidGains(integral=20000.0)
    assert scenario.voltage_limit == 24.0
    assert scenario.model.lead_screw.pitch == PITCH
    assert twin.believed.lead_screw.pitch == 2.0 * PITCH
    assert twin.redesign.pid == PidGains(integral=25000.0)
    assert (twin.telemetry_period, twin.link.communication_delay) == (0.2, 0.0)


def test_other_values_change_their_part_and_no_other_one(parameters):
    changed = parameters.with_values(
        {("plant", "gap.initial"): 0.3, ("twin", "dead_zone.ratio"): 0.5}
    )
    differing = {
        part for part, value in changed.parts.items() if value is not parameters.parts[part]
    }
    assert differing == {part_of("plant", "gap.initial")[0], part_of("twin", "dead_zone.ratio")[0]}
    assert changed.scenario(1.0).gap.initial == 0.3
    assert parameters.scenario(1.0).gap.initial == 0.2


def test_values_that_do_not_go_together_have_the_names_of_ros(parameters):
    text = r"twin: dead_zone\.minimum = 0\.5 m: must be at most maximum \(0\.1 m\)"
    with pytest.raises(ValueError, match=text):
        parameters.with_values(
            {("twin", "dead_zone.minimum"): 0.5, ("twin", "dead_zone.maximum"): 0.1}
        )


def test_seeds_are_those_of_noise_and_link_and_an_ideal_sensor_has_none(parameters):
    noisy = parameters.with_values({("plant", "sensor.noise"): 1e-6})
    assert parameters.scenario(1.0, seed=5).sensor == parameters.scenario(1.0).sensor
    assert noisy.scenario(1.0, seed=5).sensor.seed == 5
    assert noisy.twin(seed=5).link.link_seed == 5


def test_a_twin_that_only_estimates_sets_nothing(parameters):
    told = parameters.with_values({("twin", "reconfigure"): False})
    runs = [simulate_setup(one.scenario(6.0), one.twin(), ()) for one in (told, parameters)]
    assert len(runs[0].estimates) == len(runs[1].estimates) > 20
    assert runs[0].tolerances.max() == 0.0 < runs[1].tolerances.max()


class KnowingEstimator:
    """Knows the gap at once."""

    def restart(self):
        """Nothing is kept."""

    def update(self, batch, *, newest_only=False):
        return Estimate(batch[-1, 0], 0.1)


def test_the_dead_zone_has_the_pitch_that_the_twin_believes_in(parameters):
    twin = parameters.twin()
    loop = parameters.scenario(1.0)
    run = simulate_with_twin(loop, KnowingEstimator(), twin.link, believed=twin.believed)
    assert run.tolerances[-1] == tolerance_for_gap(0.1, 2.0 * PITCH)
