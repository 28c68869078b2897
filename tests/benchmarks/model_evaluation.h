#pragma once
#include <utility>
#include <vector>

#include "../../src/fit/focus_residuals.h"
#include "benchmark_scene.h"

namespace aberfit::benchmarks {

/// One step of a fit: the statistics for given white coordinates, with or without their Jacobian. Every call
/// is at a new point, as in a fit, because a model may remember its last one.
class ModelEvaluation {
 public:
  static constexpr double kWidth = 0.02;  // of focal_sigma
  using Jacobian = decltype(std::declval<internal::WhiteResiduals::Linearisation>().jacobian);

  ModelEvaluation(const Scene& scene, const std::vector<Statistic>& statistics)
      : problem_(scene.problem(targets_of(scene, statistics, 2, 1e-3))),
        model_(problem_, kWidth * scene.focal_sigma, 1),
        white_{draw_white(scene.prior.size(), 1), draw_white(scene.prior.size(), 1)} {
    white_[1][0] += 1e-9;  // another point, the same work
  }
  ModelEvaluation(const ModelEvaluation&) = delete;  // the model refers to the problem
  ModelEvaluation& operator=(const ModelEvaluation&) = delete;

  void values() { model_(next(), &values_, nullptr); }
  void values_and_jacobian() { model_(next(), &values_, &jacobian_); }

  /// Jacobian by one-sided differences of every coefficient, the cost of a solver without derivatives.
  void differences() {
    Eigen::VectorXd moved = next(), there;
    model_(moved, &values_, nullptr);
    jacobian_.resize(values_.size(), moved.size());
    for (Eigen::Index j = 0; j < moved.size(); ++j) {
      const double here = moved[j];
      moved[j] += 1e-4;
      model_(moved, &there, nullptr);
      jacobian_.col(j) = (there - values_) / 1e-4;
      moved[j] = here;
    }
  }

  /// derivative_error of the Jacobian along a random direction.
  double error() {
    const Eigen::VectorXd at = next(), along = draw_white(at.size(), 3);
    model_(at, &values_, &jacobian_);
    const auto moved = [&](double t) {
      Eigen::VectorXd there;
      model_(at + t * along, &there, nullptr);
      return there;
    };
    return derivative_error(moved, values_, jacobian_ * along);
  }

 private:
  const Eigen::VectorXd& next() { return white_[turn_ ^= 1]; }

  FitProblem problem_;
  internal::StatisticsModel model_;
  Eigen::VectorXd white_[2];
  int turn_ = 0;
  Eigen::VectorXd values_;
  Jacobian jacobian_;
};

}  // namespace aberfit::benchmarks
