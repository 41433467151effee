/// EKF-SLAM with nothing around it: fixed capacity, known identities, Ackerman odometry, range and bearing. The floor in time for a
/// filter of this size, written with Eigen alone.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <variant>
#include <vector>

#include "ssjs/features/event.hpp"

namespace ssjs::benchmarks {

/// State [x y heading | x y | ...]; P holds its lower triangle. Identities run from 0 to below the capacity.
struct BareEkf {
  static constexpr Eigen::Index kMaxObservations = 64;  // of one scan

  BareEkf(const AckermanConfig& vehicle_config, Eigen::Index capacity)
      : vehicle(vehicle_config),
        x(Eigen::VectorXd::Zero(3 + 2 * capacity)),
        P(Eigen::MatrixXd::Zero(x.size(), x.size())),
        row_of(static_cast<std::size_t>(capacity), 0),
        PHt(x.size(), 2 * kMaxObservations),
        S(2 * kMaxObservations, 2 * kMaxObservations),
        innovation(2 * kMaxObservations) {}

  void feed(const Event& event) {
    if (event.time_s > time_s) predict(event.time_s - time_s);
    time_s = event.time_s;
    if (const auto* command = std::get_if<AckermanControl>(&event.record)) control = *command;
    if (const auto* scan = std::get_if<Features>(&event.record)) update(*scan);
  }

  void predict(double dt) {  // the cross covariance waits in `transition` for the next scan
    const double s = std::sin(x(2)), c = std::cos(x(2)), alpha = control.steering_rad;
    const double tangent = std::tan(alpha), sec2 = 1.0 + tangent * tangent,
                 q = 1.0 - tangent * vehicle.encoder_offset_m / vehicle.wheelbase_m;
    const double v = control.speed_m_s / q, w = tangent / vehicle.wheelbase_m;
    const double A = vehicle.reference_forward_m * s + vehicle.reference_left_m * c;
    const double B = vehicle.reference_forward_m * c - vehicle.reference_left_m * s;
    const Eigen::Vector3d d(dt * (c - w * A), dt * (s + w * B), dt * w);
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(0, 2) = -dt * v * (s + w * B);
    F(1, 2) = dt * v * (c - w * A);
    x.head<3>() += v * d;
    if (control.speed_m_s == 0.0) return;
    Eigen::Matrix<double, 3, 2> G;
    G.col(0) = d / q;
    G.col(1) = d * control.speed_m_s * vehicle.encoder_offset_m / vehicle.wheelbase_m * sec2 / (q * q) +
               dt * v * sec2 / vehicle.wheelbase_m * Eigen::Vector3d(-A, B, 1.0);
    G.col(0) *= vehicle.speed_sigma_m_s * std::sqrt(vehicle.noise_step_s / dt);
    G.col(1) *= vehicle.steering_sigma_rad * std::sqrt(vehicle.noise_step_s / dt);
    const Eigen::Matrix3d P_vehicle = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
    P.topLeftCorner<3, 3>() = F * P_vehicle * F.transpose() + G * G.transpose();
    transition = F * transition;
  }

  void update(const Features& scan) {
    auto cross = P.block(3, 0, size - 3, 3);
    cross = (cross * transition.transpose()).eval();
    transition.setIdentity();
    const Eigen::Matrix3d P_vehicle = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
    const Eigen::Index n = size;
    Eigen::Index k = 0;
    H.clear();
    for (const Feature& z : scan) {
      const Eigen::Index row = row_of[static_cast<std::size_t>(*z.landmark_id)];
      if (row == 0) continue;
      const double dx = x(row) - x(0), dy = x(row + 1) - x(1), r2 = dx * dx + dy * dy, r = std::sqrt(r2);
      Observation h{row, {}, {}, z.covariance};
      h.landmark << dx / r, dy / r, -dy / r2, dx / r2;
      h.vehicle << -h.landmark, Eigen::Vector2d(0.0, -1.0);
      innovation.segment<2>(k) << z.range() - r, std::remainder(z.bearing() - std::atan2(dy, dx) + x(2), 2.0 * kPi);
      PHt.block<3, 2>(0, k).noalias() = P_vehicle * h.vehicle.transpose() + P.block<2, 3>(row, 0).transpose() * h.landmark.transpose();
      PHt.block(3, k, row - 3, 2).noalias() = P.block(row, 3, 2, row - 3).transpose() * h.landmark.transpose();
      P(row, row + 1) = P(row + 1, row);
      PHt.block(row, k, n - row, 2).noalias() = P.block(row, row, n - row, 2) * h.landmark.transpose();
      PHt.block(3, k, n - 3, 2).noalias() += P.block(3, 0, n - 3, 3) * h.vehicle.transpose();
      H.push_back(h);
      k += 2;
    }
    if (k > 0) {
      auto S_now = S.topLeftCorner(k, k);
      for (Eigen::Index i = 0; i < k; i += 2) {
        const Observation& h = H[static_cast<std::size_t>(i / 2)];
        S_now.middleRows<2>(i).noalias() = h.vehicle * PHt.block(0, 0, 3, k) + h.landmark * PHt.block(h.row, 0, 2, k);
        S_now.block<2, 2>(i, i) += h.R;
      }
      const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> LLt(S_now);
      auto Y = PHt.topLeftCorner(n, k);
      LLt.matrixU().solveInPlace<Eigen::OnTheRight>(Y);
      LLt.matrixL().solveInPlace(innovation.head(k));
      x.head(n).noalias() += Y * innovation.head(k);
      P.topLeftCorner(n, n).selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
    }
    for (const Feature& z : scan) {
      Eigen::Index& row = row_of[static_cast<std::size_t>(*z.landmark_id)];
      if (row != 0) continue;
      row = size;
      const double s = std::sin(x(2) + z.bearing()), c = std::cos(x(2) + z.bearing()), r = z.range();
      Eigen::Matrix<double, 2, 3> J;
      J << 1.0, 0.0, -r * s, 0.0, 1.0, r * c;
      Eigen::Matrix2d J_z;
      J_z << c, -r * s, s, r * c;
      x.segment<2>(row) << x(0) + r * c, x(1) + r * s;
      const Eigen::Matrix3d P_now = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
      P.block<2, 3>(row, 0) = J * P_now;
      P.block(row, 3, 2, row - 3).noalias() = J * P.block(3, 0, row - 3, 3).transpose();
      P.block<2, 2>(row, row) = J * P_now * J.transpose() + J_z * z.covariance * J_z.transpose();
      size += 2;
    }
  }

  struct Observation {
    Eigen::Index row;
    Eigen::Matrix<double, 2, 3> vehicle;
    Eigen::Matrix2d landmark, R;
  };

  AckermanConfig vehicle;
  AckermanControl control;
  double time_s = 0.0;
  Eigen::Index size = 3;
  Eigen::VectorXd x;
  Eigen::MatrixXd P;
  Eigen::Matrix3d transition = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Index> row_of;  ///< first row of a landmark; 0: not seen yet
  std::vector<Observation> H;
  Eigen::MatrixXd PHt, S;
  Eigen::VectorXd innovation;
};

}  // namespace ssjs::benchmarks
