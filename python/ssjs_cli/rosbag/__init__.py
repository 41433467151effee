"""ROS recordings (bags of ROS 1 and ROS 2) as missions of an underwater vehicle."""
