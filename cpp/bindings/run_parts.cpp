#include "run_parts.hpp"

#include "columns.hpp"

namespace ssjs::bindings {

py::list loop_list(const std::vector<LoopAttempt>& loops) {
  py::list list;
  for (const LoopAttempt& loop : loops) {
    py::dict entry;
    entry["time_s"] = loop.time_s;
    entry["from"] = loop.from;
    entry["to"] = loop.to;
    entry["accepted"] = loop.accepted;
    entry["reason"] = loop.reason;
    entry["pairs"] = loop.pairs;
    entry["wrong_pairs"] = loop.wrong_pairs;
    entry["chi2"] = loop.chi_squared;
    entry["dof"] = loop.dof;
    entry["sigma_m"] = loop.sigma_m;
    list.append(entry);
  }
  return list;
}

py::dict update_dict(const std::vector<MissionResult::Update>& updates) {
  const auto n = static_cast<Eigen::Index>(updates.size());
  Eigen::VectorXd time_s(n);
  Eigen::VectorXd nis(n);
  std::vector<std::int64_t> dof;
  for (Eigen::Index i = 0; i < n; ++i) {
    const MissionResult::Update& update = updates[static_cast<std::size_t>(i)];
    time_s(i) = update.time_s;
    nis(i) = update.nis;
    dof.push_back(update.dof);
  }
  py::dict dict;
  dict["time_s"] = time_s;
  dict["nis"] = nis;
  dict["dof"] = array_of(dof);
  return dict;
}

ProgressSink progress_sink(const std::optional<std::function<bool(double)>>& progress) {
  if (!progress) return {};
  return [progress](double fraction) {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return (*progress)(fraction);
  };
}

}  // namespace ssjs::bindings
