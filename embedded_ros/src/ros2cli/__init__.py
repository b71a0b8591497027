"""The ``ros2`` command for machines without ROS 2.

``commands`` says what can be typed, and names the function that does it; that one's module is
imported when it is called.
"""
