"""Interfaces of the ROS 2 package actionlib_msgs."""
