/// Progress of long calls, reported through an argument: the library writes nowhere by itself.
#pragma once

#include <functional>

namespace ssjs {

/// Called now and then with the finished fraction in [0, 1]; returning false asks the call to stop (it throws Cancelled).
using ProgressSink = std::function<bool(double fraction)>;

}  // namespace ssjs
