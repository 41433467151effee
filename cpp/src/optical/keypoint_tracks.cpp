#include "ssjs/optical/keypoint_tracks.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/disjoint_sets.hpp"

namespace ssjs {
namespace {

/// Sets of keypoints, and by set the frames that they are of, ascending.
class GrowingTracks {
 public:
  explicit GrowingTracks(const std::vector<int>& keypoints_of_frame) {
    for (std::size_t frame = 0; frame < keypoints_of_frame.size(); ++frame) {
      begin_.push_back(static_cast<int>(frames_.size()));
      for (int i = 0; i < keypoints_of_frame[frame]; ++i) {
        sets_.add();
        frames_.push_back({static_cast<int>(frame)});
      }
    }
    begin_.push_back(static_cast<int>(frames_.size()));
  }

  [[nodiscard]] int keypoint(int frame, int row) const {
    const int frames = static_cast<int>(begin_.size()) - 1;
    if (frame < 0 || frame >= frames) throw InvalidArgument("frame", frame, "of a link must be one of the frames");
    const auto f = static_cast<std::size_t>(frame);
    if (row < 0 || row >= begin_[f + 1] - begin_[f]) throw InvalidArgument("rows", row, "of a link must be keypoints of its frame");
    return begin_[f] + row;
  }

  void unite(int a, int b) {
    a = sets_.smallest(a);
    b = sets_.smallest(b);
    if (a == b) return;
    std::vector<int>& of_a = frames_[static_cast<std::size_t>(a)];
    std::vector<int>& of_b = frames_[static_cast<std::size_t>(b)];
    std::vector<int> both;
    std::set_union(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(both));
    if (both.size() < of_a.size() + of_b.size()) return;  // one place cannot be at two in a frame
    sets_.unite(a, b);
    of_a.clear();
    of_b.clear();
    frames_[static_cast<std::size_t>(sets_.smallest(a))] = std::move(both);
  }

  [[nodiscard]] std::vector<std::vector<int>> numbered() {
    std::vector<int> number(frames_.size(), -1);
    std::vector<std::vector<int>> tracks(begin_.size() - 1);
    int next = 0;
    for (std::size_t frame = 0; frame + 1 < begin_.size(); ++frame) {
      for (int k = begin_[frame]; k < begin_[frame + 1]; ++k) {
        const auto set = static_cast<std::size_t>(sets_.smallest(k));
        if (frames_[set].size() > 1 && number[set] < 0) number[set] = next++;
        tracks[frame].push_back(number[set]);
      }
    }
    return tracks;
  }

 private:
  DisjointSets sets_;
  std::vector<std::vector<int>> frames_;
  std::vector<int> begin_;  ///< number of each frame's first keypoint
};

}  // namespace

std::vector<std::vector<int>> keypoint_tracks(const std::vector<int>& keypoints_of_frame, const std::vector<FrameLink>& links) {
  GrowingTracks tracks(keypoints_of_frame);
  for (const FrameLink& link : links) {  // (V-20)
    for (const auto& [row_a, row_b] : link.rows) tracks.unite(tracks.keypoint(link.first, row_a), tracks.keypoint(link.second, row_b));
  }
  return tracks.numbered();
}

std::vector<int> chosen_tracks(const std::vector<std::vector<int>>& tracks, int per_frame) {
  std::vector<std::vector<int>> frames_of;
  for (std::size_t frame = 0; frame < tracks.size(); ++frame) {
    for (const int track : tracks[frame]) {
      if (track < 0) continue;
      if (static_cast<std::size_t>(track) >= frames_of.size()) frames_of.resize(static_cast<std::size_t>(track) + 1);
      frames_of[static_cast<std::size_t>(track)].push_back(static_cast<int>(frame));
    }
  }
  std::vector<int> order(frames_of.size());
  std::iota(order.begin(), order.end(), 0);
  const auto length = [&](int track) { return frames_of[static_cast<std::size_t>(track)].size(); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return length(a) > length(b); });
  std::vector<int> shown(tracks.size(), 0), chosen;
  for (const int track : order) {
    const std::vector<int>& frames = frames_of[static_cast<std::size_t>(track)];
    const auto wants = [&](int frame) { return shown[static_cast<std::size_t>(frame)] < per_frame; };
    if (!std::any_of(frames.begin(), frames.end(), wants)) continue;
    for (const int frame : frames) ++shown[static_cast<std::size_t>(frame)];
    chosen.push_back(track);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace ssjs
