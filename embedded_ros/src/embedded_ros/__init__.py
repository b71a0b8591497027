"""What stands under the embedded ``rclpy``: Cyclone DDS, CDR, message classes, argument parsing.

Nothing here is public. Code that runs on a real ROS 2 as well imports ``rclpy`` and the message
packages only.
"""
