"""`bdt run --supervise`: a node that dies is started anew, and the others go on."""

import json
import os
import signal
import time
from types import SimpleNamespace

import pytest
from running_loops import DEADLINE, alive, bdt, children, finished, wait_for, wait_for_the_loop

from bdt_bringup.supervisor import Supervisor
from bdt_msgs_py.command_errors import BadInputError, LoopError


class Run:
    """A supervised run, of which nodes are killed."""

    def __init__(self, output, domain, *arguments):
        self.domain = domain
        words = ("run", "--supervise", "--config", "paper", "--output", output, *arguments)
        self.process = bdt(*words, domain=domain)
        wait_for_the_loop(self.process, output)

    def kill(self, name):
        """Kill a node, and wait for its successor."""
        victim = children(self.process.pid)[name]
        os.kill(victim, signal.SIGKILL)

        def is_back():
            assert self.process.poll() is None, self.process.communicate()[1]
            return children(self.process.pid).get(name, victim) != victim

        wait_for(is_back, f"{name} comes anew")

    def status(self):
        code, out, _ = finished(bdt("status", domain=self.domain))
        return code, out.splitlines()[0]


@pytest.fixture
def supervised(tmp_path, claim_domain):
    """Return a function that starts a supervised run, which ends with the test."""
    runs = []

    def start(*arguments):
        runs.append(Run(tmp_path / "run", claim_domain(), *arguments))
        return runs[-1]

    yield start
    for run in runs:
        # The nodes end with it.
        run.process.kill()
        run.process.communicate()


def test_controller_and_twin_of_a_lockstep_loop_are_replaced_and_the_run_ends_well(supervised):
    run = supervised("--duration", "40", "--json")
    nodes = children(run.process.pid)
    run.kill("controller")
    run.kill("twin")
    successors = children(run.process.pid)
    assert successors["plant"] == nodes["plant"]
    assert successors["recorder"] == nodes["recorder"]
    code, out, err = finished(run.process)
    assert code == 0, err
    for name in ("controller", "twin"):
        assert f"node {name}: killed by SIGKILL: is started anew in 0.25 s" in err
    summary = json.loads(out)
    assert summary["duration_s"] == pytest.approx(40.0, abs=1e-3)
    # The gap is 2.7 degrees by then: the twin has gone on with setting the dead zone for it.
    assert summary["dead_zone_final_m"] > 6e-6
    assert not any(alive(pid) for pid in successors.values())


def test_a_recorder_that_dies_begins_another_bag(tmp_path, supervised):
    run = supervised("--duration", "40")
    run.kill("recorder")
    code, out, err = finished(run.process)
    assert code == 0, err
    first, second = tmp_path / "run" / "bag", tmp_path / "run" / "bag-2"
    assert out == f"bags, as the recorder was started anew: {first} {second}\n"
    assert (second / "metadata.yaml").is_file()


def test_a_plant_that_dies_ends_the_run(supervised):
    run = supervised("--duration", "1000")
    os.kill(children(run.process.pid)["plant"], signal.SIGKILL)
    code, _, err = finished(run.process)
    assert code == 1
    assert "error: node plant: killed by SIGKILL" in err


def test_the_status_of_a_loop_names_who_is_silent(supervised):
    run = supervised("--duration", "1000", "--mode", "realtime")
    wait_for(lambda: run.status() == (0, "ok: 4 nodes are well"), "the loop is well")
    watcher = bdt("status", "--watch", domain=run.domain)
    # A busy machine misses a measurement now and then.
    wait_for(lambda: "ok: 4 nodes are well" in watcher.stdout.readline(), "it is well")
    twin = children(run.process.pid)["twin"]
    os.kill(twin, signal.SIGSTOP)
    wait_for(
        lambda: "degraded: twin: has said nothing for" in watcher.stdout.readline(), "it is told"
    )
    run.process.send_signal(signal.SIGINT)
    os.kill(twin, signal.SIGCONT)
    code, _, err = finished(run.process)
    assert code == 130, err
    watcher.send_signal(signal.SIGINT)
    assert finished(watcher)[0] == 130
    assert run.status() == (1, "stopped: no node has said anything")


def test_a_loop_in_one_process_cannot_be_supervised(tmp_path):
    words = ("--supervise", "--processes", "single", "--output", tmp_path / "run")
    code, _, err = finished(bdt("run", *words))
    assert code == 2
    assert err == "error: --supervise: needs processes of their own: --processes separate\n"


@pytest.fixture
def supervisor(tmp_path, monkeypatch):
    """Return a function that supervises a node whose main is given, beside a plant that stays."""
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    (tmp_path / "pretended_plant.py").write_text("import time\ndef main(_):\n    time.sleep(600)\n")
    created = []

    def supervise(text, *, restart=True):
        (tmp_path / "pretended_twin.py").write_text(f"import sys\ndef main(_):\n    {text}\n")
        plan = SimpleNamespace(
            output=tmp_path,
            supervise=restart,
            machine="plant",
            modules={name: f"pretended_{name}" for name in ("twin", "plant")},
            ros_arguments=lambda name, life: [f"{name}:={life}"],
        )
        created.append(Supervisor(plan))
        created[-1].start_all()
        return created[-1]

    yield supervise
    for one in created:
        one.stop()


def look_until_error(supervisor):
    end = time.monotonic() + DEADLINE
    while time.monotonic() < end:
        supervisor.look()
        time.sleep(0.01)
    raise AssertionError("no error")


def test_a_node_that_dies_again_and_again_is_given_up_with_what_it_said(
    supervisor, monkeypatch, capsys
):
    monkeypatch.setattr("bdt_bringup.restart_policy.MOST_RESTARTS", 2)
    monkeypatch.setattr("bdt_bringup.restart_policy.FIRST_DELAY", 0.01)
    with pytest.raises(LoopError, match=r"node twin: exit code 3: .*life twin:=3.* restarts"):
        look_until_error(supervisor("print('life', _[-1]); sys.exit(3)"))
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2
    assert all("node twin: exit code 3" in line for line in told)


def test_a_node_that_refuses_its_parameters_is_not_started_anew(supervisor, capsys):
    with pytest.raises(BadInputError, match="node twin: exit code 2"):
        look_until_error(supervisor("sys.exit(2)"))
    assert capsys.readouterr().err == ""


def test_without_supervision_the_first_death_ends_the_run(supervisor, capsys):
    with pytest.raises(LoopError, match="node twin: exit code 3"):
        look_until_error(supervisor("sys.exit(3)", restart=False))
    assert capsys.readouterr().err == ""
