"""Parts of rclpy under the names where user code finds them."""
