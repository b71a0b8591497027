#!/bin/sh
# Three plots of rqt_plot in one window, over 30 s, while a loop runs: position [m], motor voltage
# [V] and estimated gap [rad]. The perspective is there for their vertical scales: by its command
# line rqt_plot has one for all and begins at 0 to 1, where 5 mm are a flat line. Left out are
# `reference`, which is published at its steps only and would be joined by ramps, and `truth`,
# which has no stamp. rqt_plot subtracts the wall time of its start from the stamps: in simulated
# time its axis reads about -1.8e9 s, and only spans mean something.
exec ros2 run rqt_gui rqt_gui --perspective-file "$(dirname "$0")/rqt_plot.perspective"
