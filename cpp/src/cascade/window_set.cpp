#include "ssjs/cascade/window_set.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

class Fnv1a {
 public:
  void add(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3U; }
  void add(int number) {
    const auto bits = static_cast<std::uint32_t>(number);
    for (int shift = 0; shift < 32; shift += 8) add(static_cast<unsigned char>((bits >> shift) & 0xffU));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

/// Those of `names`, not all of them, whose number of entries in `recordings` is nearest to `wanted`, the lesser of two equally near.
/// Of several choices: names at the end of the list are done without first.
std::vector<int> nearest_in_sum(const std::vector<int>& names, const std::vector<int>& recordings, double wanted) {
  std::vector<std::size_t> sizes;
  for (const int name : names) sizes.push_back(static_cast<std::size_t>(std::count(recordings.begin(), recordings.end(), name)));
  // reached[k][n]: some of the first k recordings have n entries
  std::vector<std::vector<bool>> reached(names.size() + 1, std::vector<bool>(recordings.size() + 1, false));
  reached[0][0] = true;
  for (std::size_t k = 0; k < names.size(); ++k)
    for (std::size_t n = 0; n <= recordings.size(); ++n) reached[k + 1][n] = reached[k][n] || (n >= sizes[k] && reached[k][n - sizes[k]]);
  std::size_t nearest = 0;
  for (std::size_t n = 0; n < recordings.size(); ++n)  // all of them would leave nothing
    if (reached.back()[n] && std::abs(static_cast<double>(n) - wanted) < std::abs(static_cast<double>(nearest) - wanted)) nearest = n;
  std::vector<int> chosen;
  for (std::size_t k = names.size(); k > 0; --k) {
    if (reached[k - 1][nearest]) continue;
    chosen.push_back(names[k - 1]);
    nearest -= sizes[k - 1];
  }
  return chosen;
}

std::string text(cv::Size size) { return std::to_string(size.width) + " x " + std::to_string(size.height); }

}  // namespace

WindowSet::WindowSet(cv::Size window) : window_(window) {
  if (window.width < 3 || window.height < 3) throw InvalidArgument("window", text(window), "must be at least 3 x 3 pixels");
}

void WindowSet::add(const cv::Mat& picture, int recording) {
  if (picture.type() != CV_8UC1 || picture.size() != window_)
    throw InvalidArgument("picture", text(picture.size()), "must be one 8-bit channel of " + text(window_));
  for (int y = 0; y < picture.rows; ++y) pixels_.insert(pixels_.end(), picture.ptr(y), picture.ptr(y) + picture.cols);
  recordings_.push_back(recording);
}

void WindowSet::append(const WindowSet& other) {
  if (other.window_ != window_) throw InvalidArgument("windows", text(other.window_), "must be of " + text(window_));
  pixels_.insert(pixels_.end(), other.pixels_.begin(), other.pixels_.end());
  recordings_.insert(recordings_.end(), other.recordings_.begin(), other.recordings_.end());
}

cv::Mat WindowSet::operator[](std::size_t index) const {
  const std::size_t area = static_cast<std::size_t>(window_.area());
  return {window_, CV_8U, const_cast<unsigned char*>(pixels_.data() + index * area)};  // cv::Mat knows no view of constants
}

WindowSet WindowSet::select(const std::vector<std::size_t>& indices) const {
  WindowSet chosen(window_);
  for (const std::size_t index : indices) chosen.add((*this)[index], recordings_[index]);
  return chosen;
}

std::uint64_t WindowSet::digest() const {
  Fnv1a hash;
  hash.add(window_.width);
  hash.add(window_.height);
  for (const int recording : recordings_) hash.add(recording);
  for (const unsigned char pixel : pixels_) hash.add(pixel);
  return hash.value();
}

cv::Mat window_of(const cv::Mat& image, const cv::Rect& box, cv::Size window) {
  if (image.type() != CV_8UC1) throw InvalidArgument("image", cv::typeToString(image.type()), "must be one 8-bit channel");
  if (box.width <= 0 || box.height <= 0) throw InvalidArgument("box", text(box.size()), "must not be empty");
  const double scale = std::max(static_cast<double>(box.width) / window.width, static_cast<double>(box.height) / window.height);
  const int width = std::max(1, cvRound(scale * window.width));
  const int height = std::max(1, cvRound(scale * window.height));
  const cv::Rect grown(box.x + (box.width - width) / 2, box.y + (box.height - height) / 2, width, height);
  if ((grown & cv::Rect({0, 0}, image.size())) != grown) return {};
  cv::Mat picture;
  cv::resize(image(grown), picture, window, 0, 0, cv::INTER_LINEAR_EXACT);  // as the detector scales pictures
  return picture;
}

SampleSplit split_by_recording(const std::vector<int>& recordings, double validation_fraction, const Rng& rng) {
  if (!(validation_fraction >= 0 && validation_fraction < 1))
    throw InvalidArgument("validation_fraction", validation_fraction, "must lie in [0, 1)");
  std::vector<int> names = recordings;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  Rng draw = rng.stream("split by recording");
  for (std::size_t i = names.size(); i > 1; --i) std::swap(names[i - 1], names[draw.below(i)]);

  const double wanted = validation_fraction * static_cast<double>(recordings.size());
  std::vector<int> held_back = nearest_in_sum(names, recordings, wanted);
  std::sort(held_back.begin(), held_back.end());
  SampleSplit split;
  for (std::size_t i = 0; i < recordings.size(); ++i)
    (std::binary_search(held_back.begin(), held_back.end(), recordings[i]) ? split.validation : split.training).push_back(i);
  return split;
}

}  // namespace ssjs
