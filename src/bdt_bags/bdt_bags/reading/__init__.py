"""Bags as numpy arrays, without ROS."""
