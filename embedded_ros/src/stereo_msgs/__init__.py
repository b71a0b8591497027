"""Interfaces of the ROS 2 package stereo_msgs."""
