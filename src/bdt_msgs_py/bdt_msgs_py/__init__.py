"""Vocabulary of the backlash digital twin: topics, stamps, messages as arrays, parameters.

Nothing is imported here, so that the pure cores can use :mod:`bdt_msgs_py.quantities` without
pulling in rclpy.
"""
