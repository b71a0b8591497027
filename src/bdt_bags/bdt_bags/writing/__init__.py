"""Bags as Jazzy's rosbag2 writes them, with nothing older than a second left in memory."""
