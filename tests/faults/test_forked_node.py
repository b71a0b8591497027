"""Nodes that are forked from a process that has imported all of them."""

from forked_node import ForkedNode


def test_a_node_finds_all_nodes_imported(tmp_path, monkeypatch):
    (tmp_path / "telling.py").write_text(
        "import sys\n\ndef main(arguments):\n    print(*arguments, *sys.modules, flush=True)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    log = tmp_path / "log"
    node = ForkedNode("telling", ["a", "b"], log, {})
    assert node.wait(60.0) == 0
    said = log.read_text().split()
    assert said[:3] == ["telling", "a", "b"]
    assert "node_imports" in said
