#pragma once
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cstddef>
#include <optional>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/psd_jacobian.h"
#include "exact_variable.h"
#include "focal_bins.h"

namespace aberfit::internal {

/// Energy in circles or rings [total 1] as a function of the natural logarithms of the unknowns over their
/// starts. The arguments must outlive the object.
class FocusModelLight {
 public:
  FocusModelLight(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns, const FocalBins& bins,
                  double dz, const GhsPupil& pupil, int threads)
      : task_at_(task_at), unknowns_(unknowns), bins_(bins), pupil_(pupil), threads_(threads) {
    for (std::size_t u = 0; u < unknowns.size(); ++u)
      variables_.push_back(exact_variable(task_at, unknowns, u));
    for (const double radius : bins.nodes) statistics_.push_back(RingThrough{radius, dz});
  }

  /// Computes the energy in each bin and, if `slopes` is given, its derivatives over the logarithms. Returns
  /// false if the values are not allowed or have no prediction.
  bool at(const std::vector<double>& logs, Eigen::VectorXd* light, Eigen::MatrixXd* slopes) const {
    try {
      if (slopes)
        with_slopes(logs, light, slopes);
      else
        *light = bins_.weights * energies(logs);
      return light->allFinite() && (!slopes || slopes->allFinite());
    } catch (const InputError&) {
    } catch (const ComputationError&) {
    }
    return false;
  }

 private:
  Task task(const std::vector<double>& logs) const { return task_at_(values_at(unknowns_, logs)); }
  Eigen::VectorXd energies(const std::vector<double>& logs) const {
    return GeneralisedHarveyShack(RadialPsd(*task(logs).psd), pupil_).predict(statistics_, threads_);
  }
  void with_slopes(const std::vector<double>& logs, Eigen::VectorXd* light, Eigen::MatrixXd* slopes) const {
    std::vector<PsdVariable> exact;
    for (const std::optional<PsdVariable>& variable : variables_)
      if (variable) exact.push_back(*variable);
    const PsdJacobian found = psd_jacobian(*task(logs).psd, exact, statistics_, pupil_, threads_);
    *light = bins_.weights * found.values;
    slopes->resize(light->size(), Eigen::Index(logs.size()));
    Eigen::Index known = 0;
    for (std::size_t u = 0; u < logs.size(); ++u) {
      const auto column = Eigen::Index(u);
      if (variables_[u]) {
        slopes->col(column) = bins_.weights * found.derivatives.col(known) * found.parameter_values[known];
        ++known;
        continue;
      }
      std::vector<double> above = logs, below = logs;
      above[u] += kDifference, below[u] -= kDifference;
      slopes->col(column) = bins_.weights * (energies(above) - energies(below)) / (2 * kDifference);
    }
  }

  const TaskAt& task_at_;
  const std::vector<SolveUnknown>& unknowns_;
  const FocalBins& bins_;
  const GhsPupil& pupil_;
  int threads_;
  std::vector<std::optional<PsdVariable>> variables_;
  std::vector<Statistic> statistics_;
};

inline std::vector<double> logs_of(const Eigen::VectorXd& x, std::size_t count) {
  return {x.data(), x.data() + count};
}

struct FocusProblemStart {
  Eigen::VectorXd x;
  double sum_of_squares = 0;
};

/// The complete problem, whitened by the covariance of the data. Parameters are the logarithms of the
/// unknowns, then total energy and background if unknown. The arguments must outlive the object.
class FocusProblem {
 public:
  FocusProblem(const FocusModelLight& model, const FocalBins& bins, const MeasuredFocus& focus,
               std::size_t unknowns)
      : model_(model), bins_(bins), unknowns_(unknowns) {
    has_total_ = bins.are_rings || !focus.is_total_known;
    has_background_ = bins.are_rings && focus.has_background;
  }

  /// Sets the covariance. If it is singular to rounding, its diagonal is raised slightly. Throws
  /// ComputationError if it is still not positive definite.
  void set_covariance(const Eigen::MatrixXd& covariance) {
    whitening_ = covariance.llt();
    for (double floor = 1e-12; whitening_.info() != Eigen::Success && floor < 1; floor *= 100) {
      Eigen::MatrixXd raised = covariance;
      raised.diagonal() *= 1 + floor;
      whitening_ = raised.llt();
    }
    if (whitening_.info() != Eigen::Success)
      throw ComputationError(
          "noise and spread of the measured values do not form a covariance matrix; check `noise`");
  }

  std::size_t parameters() const {
    return unknowns_ + std::size_t(has_total_) + std::size_t(has_background_);
  }
  double total(const Eigen::VectorXd& x) const { return has_total_ ? x[Eigen::Index(unknowns_)] : 1; }
  double background(const Eigen::VectorXd& x) const { return has_background_ ? x[x.size() - 1] : 0; }

  bool residuals(const Eigen::VectorXd& x, Eigen::VectorXd* residuals, Eigen::MatrixXd* jacobian) const {
    Eigen::VectorXd light;
    Eigen::MatrixXd slopes;
    if (!model_.at(logs_of(x, unknowns_), &light, jacobian ? &slopes : nullptr)) return false;
    *residuals = whitened(x, light);
    if (!jacobian) return true;
    Eigen::MatrixXd plain(light.size(), Eigen::Index(parameters()));
    plain.leftCols(slopes.cols()) = total(x) * slopes;
    if (has_total_) plain.col(Eigen::Index(unknowns_)) = light;
    if (has_background_) plain.col(plain.cols() - 1) = bins_.pixels.matrix();
    *jacobian = whitening_.matrixL().solve(plain);
    return true;
  }

  Eigen::MatrixXd plain(const Eigen::MatrixXd& white) const { return whitening_.matrixL() * white; }
  Eigen::MatrixXd whitened_columns(const Eigen::MatrixXd& columns) const {
    return whitening_.matrixL().solve(columns);
  }

  /// Returns the best total and background for these unknowns; nothing if there is no prediction.
  std::optional<FocusProblemStart> start(const std::vector<double>& logs) const {
    Eigen::VectorXd light;
    if (!model_.at(logs, &light, nullptr)) return std::nullopt;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(Eigen::Index(parameters()));
    for (std::size_t u = 0; u < unknowns_; ++u) x[Eigen::Index(u)] = logs[u];
    if (has_total_) {
      Eigen::MatrixXd design(light.size(), has_background_ ? 2 : 1);
      design.col(0) = light;
      if (has_background_) design.col(1) = bins_.pixels.matrix();
      const Eigen::MatrixXd white = whitening_.matrixL().solve(design);
      const Eigen::VectorXd wanted = whitening_.matrixL().solve(bins_.measured.matrix());
      x.tail(design.cols()) = white.colPivHouseholderQr().solve(wanted);
    }
    return FocusProblemStart{x, whitened(x, light).squaredNorm()};
  }

 private:
  Eigen::VectorXd whitened(const Eigen::VectorXd& x, const Eigen::VectorXd& light) const {
    return whitening_.matrixL().solve(
        (total(x) * light.array() + background(x) * bins_.pixels - bins_.measured).matrix());
  }

  const FocusModelLight& model_;
  const FocalBins& bins_;
  std::size_t unknowns_;
  bool has_total_ = false, has_background_ = false;
  Eigen::LLT<Eigen::MatrixXd> whitening_;
};

}  // namespace aberfit::internal
