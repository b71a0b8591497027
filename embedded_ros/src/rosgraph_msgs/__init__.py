"""Interfaces of the ROS 2 package rosgraph_msgs."""
