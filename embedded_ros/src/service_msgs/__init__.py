"""Interfaces of the ROS 2 package service_msgs."""
