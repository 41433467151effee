// A program that uses ssjs::imaging: fails unless the range of an image is that of its valid pixels.
#include <ssjs/imaging/sonar_image.hpp>

int main() {
  const cv::Mat intensity = (cv::Mat_<unsigned char>(1, 3) << 7, 90, 255);
  const cv::Mat valid = (cv::Mat_<unsigned char>(1, 3) << 1, 1, 0);
  const std::optional<ssjs::IntensityRange> range = ssjs::intensity_range({intensity, valid});
  return range && range->lowest == 7 && range->highest == 90 ? 0 : 1;
}
