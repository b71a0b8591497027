"""Interfaces of the ROS 2 package unique_identifier_msgs."""
