"""The closed loop offline: the step functions of the nodes, compiled."""
