#!/bin/sh
# rqt_plot of position and reference [m], motor voltage [V] and estimated gap [rad] while a loop runs.
# The true gap is not among them: `truth` is best effort, and rqt_plot subscribes reliably.
exec ros2 run rqt_plot rqt_plot \
    "/measurement/position[0]" \
    "/reference/position[0]" \
    "/command/effort[0]" \
    "/backlash_estimate/position[0]"
