"""The loop offline: simulation, design, limit cycles, the paper again, evaluation, benchmarks."""
