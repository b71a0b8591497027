"""Micrometers of travel become degrees of the screw by the pitch that a recording tells."""

from bdt_analysis.metrics.lead_screw_pitch import lead_screw_pitch
from bdt_bags.reading.recording import load_recording
from bdt_plant.lead_screw import LeadScrewParameters


def test_the_pitch_is_that_of_the_recording(small_loop, tmp_path):
    told = small_loop.without()
    told.parameter(0.0, "/plant", "lead_screw.pitch", 2e-4, initial=True)
    assert lead_screw_pitch(load_recording(told.write(tmp_path / "bag"))) == 2e-4


def test_without_one_it_is_the_paper_s(small_loop, tmp_path):
    recording = load_recording(small_loop.write(tmp_path / "bag"))
    assert lead_screw_pitch(recording) == LeadScrewParameters().pitch
