"""Interfaces of the ROS 2 package type_description_interfaces."""
