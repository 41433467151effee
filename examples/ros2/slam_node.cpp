#include "slam_node.hpp"

int main(int count, char** arguments) {
  rclcpp::init(count, arguments);
  rclcpp::spin(std::make_shared<ssjs_ros::SlamNode>());
  rclcpp::shutdown();
  return 0;
}
