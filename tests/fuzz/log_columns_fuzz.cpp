// Columns of any shape and content put into the logs in memory: taken, or refused with InvalidArgument. What comes out is in the order of
// time and finite.
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

#include "byte_stream.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/io/event_log.hpp"
#include "ssjs/io/navigation_log.hpp"

namespace {

using ssjs::fuzz::ByteStream;

/// Now and then one of another shape or with one value that is anything.
Eigen::MatrixXd table(ByteStream& bytes, Eigen::Index rows, Eigen::Index columns) {
  const std::uint8_t damage = bytes.byte();
  if (damage == 1) rows += static_cast<Eigen::Index>(bytes.below(3)) - 1;
  if (damage == 2) columns += static_cast<Eigen::Index>(bytes.below(3)) - 1;
  if (damage == 3) rows = 0;
  Eigen::MatrixXd values(std::max<Eigen::Index>(rows, 0), columns);
  for (double& value : values.reshaped()) value = bytes.plausible(100.0);
  if (damage == 4 && values.size() > 0) values.reshaped()(static_cast<Eigen::Index>(bytes.byte()) % values.size()) = bytes.any();
  return values;
}

Eigen::VectorXd column(ByteStream& bytes, Eigen::Index rows) { return table(bytes, rows, 1).reshaped(); }

Eigen::VectorXd times(ByteStream& bytes, Eigen::Index rows) {
  Eigen::VectorXd time_s(rows);
  double now_s = bytes.plausible(100.0);
  for (double& each : time_s) {
    const std::uint8_t step = bytes.byte();
    now_s = step == 255 ? bytes.any() : now_s + 0.1 * (step % 32) - (step == 254 ? 10.0 : 0.0);
    each = now_s;
  }
  return time_s;
}

std::optional<std::vector<std::int64_t>> identities(ByteStream& bytes, Eigen::Index rows) {
  const std::uint8_t kind = bytes.byte();
  if (kind % 2 == 0) return std::nullopt;
  std::vector<std::int64_t> ids(static_cast<std::size_t>(rows) + (kind == 255 ? 1 : 0));
  for (std::int64_t& id : ids) id = static_cast<std::int64_t>(bytes.below(8)) - 2;
  return ids;
}

template <class Records>
void check_order(const Records& records) {
  double last_s = -INFINITY;
  for (const auto& record : records) {
    if (!std::isfinite(record.time_s) || record.time_s < last_s) std::abort();
    last_s = record.time_s;
  }
}

void fill(ssjs::EventLog& log, ByteStream& bytes) {
  const auto rows = static_cast<Eigen::Index>(bytes.below(12));
  const std::size_t kind = bytes.below(6);
  const Eigen::VectorXd time_s = times(bytes, rows);
  const Eigen::VectorXd a = column(bytes, rows);
  const Eigen::VectorXd b = column(bytes, rows);
  if (kind == 0) log.add_ackerman(time_s, a, b);
  if (kind == 1) log.add_velocity(time_s, a, b);
  if (kind == 2) log.add_increments(time_s, a, b, column(bytes, rows), table(bytes, rows, 6));
  if (kind == 3) log.add_features(time_s, a, b, table(bytes, rows, 3), identities(bytes, rows));
  if (kind == 4) log.add_scans(time_s, table(bytes, rows, 5), bytes.any(), bytes.any());
  if (kind == 5) log.add_sonar_hits(time_s, a, b);
}

void fill(ssjs::NavigationLog& log, ByteStream& bytes) {
  const auto rows = static_cast<Eigen::Index>(bytes.below(12));
  const std::size_t kind = bytes.below(6);
  const Eigen::VectorXd time_s = times(bytes, rows);
  if (kind == 0) log.add_attitude(time_s, table(bytes, rows, 3));
  if (kind == 1) log.add_gyro(time_s, table(bytes, rows, 3));
  if (kind == 2) log.add_depth(time_s, column(bytes, rows));
  if (kind == 3) log.add_altitude(time_s, column(bytes, rows));
  if (kind == 4) {
    std::vector<bool> lock;
    for (Eigen::Index i = 0; i < rows; ++i) lock.push_back(bytes.below(4) > 0);
    log.add_velocity(time_s, table(bytes, rows, 3), lock);
  }
  if (kind == 5) log.add_sightings(time_s, table(bytes, rows, 3), table(bytes, rows, 6), identities(bytes, rows));
}

template <class Log>
void fill_all(Log& log, ByteStream& bytes) {
  while (!bytes.empty()) {
    try {
      fill(log, bytes);
    } catch (const ssjs::InvalidArgument&) {  // says so, and is the only thing thrown
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  ByteStream bytes(data + 1, size - 1);
  if ((data[0] & 1U) == 0) {
    ssjs::EventLog log;
    fill_all(log, bytes);
    check_order(log.events());
  } else {
    ssjs::NavigationLog log;
    fill_all(log, bytes);
    check_order(log.ticks());
  }
  return 0;
}
