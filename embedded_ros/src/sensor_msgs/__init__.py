"""Interfaces of the ROS 2 package sensor_msgs."""
