"""Interfaces of the ROS 2 package statistics_msgs."""
