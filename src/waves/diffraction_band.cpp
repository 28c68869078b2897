#include "diffraction_band.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "diffraction_workspace.h"

namespace aberfit::internal {
namespace {

constexpr double kSameRadius = 1e-13;  // relative; end of the search for a radius
constexpr int kMostSteps = 60;
constexpr double kStep = 1e-4;  // relative step to either side for the slope of the energy

// One problem for each wavelength, with its irradiance weight.
class Lines {
 public:
  Lines(const DiffractionProblem& problem, const Eigen::ArrayXd& height, int threads,
        DiffractionWorkspace* workspace, const GradientReduction& reduce)
      : height_(height), threads_(threads), reduce_(reduce) {
    std::vector<DiffractionWorkspace>& spaces = workspace ? workspace->buffers().lines : own_;
    const std::vector<LightLine>& lines = problem.wavelength.lines();
    if (spaces.size() < lines.size()) spaces.resize(lines.size());
    double perfect = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      problems_.push_back(at_line(problem, k));
      spaces_.push_back(&spaces[k]);
      shares_.push_back(lines[k].share);
      irradiance_.push_back(lines[k].share / std::pow(lines[k].wavelength, 2));
      perfect += irradiance_.back();
    }
    for (double& one : irradiance_) one /= perfect;
  }

  /// Values of each wavelength, statistics x wavelengths; NaN where a value does not exist.
  Eigen::MatrixXd values(const std::vector<Statistic>& statistics,
                         std::vector<Eigen::ArrayXd>* d_sum = nullptr) {
    Eigen::MatrixXd all(Eigen::Index(statistics.size()), Eigen::Index(problems_.size()));
    if (d_sum) d_sum->assign(statistics.size(), {});
    for (std::size_t k = 0; k < problems_.size(); ++k) {
      Eigen::VectorXd of_line;
      std::vector<Eigen::ArrayXd> d_line;
      evaluate_diffraction(problems_[k], height_, statistics, threads_, spaces_[k], &of_line,
                           d_sum ? &d_line : nullptr, reduce_);
      all.col(Eigen::Index(k)) = of_line;
      for (std::size_t j = 0; d_sum && j < statistics.size(); ++j) {
        Eigen::ArrayXd& sum = (*d_sum)[j];
        if (k > 0 && sum.size() != d_line[j].size()) continue;  // this wavelength has no value
        const double weight = weights(statistics[j])[k];
        sum = k == 0 ? Eigen::ArrayXd(weight * d_line[j]) : Eigen::ArrayXd(sum + weight * d_line[j]);
      }
    }
    return all;
  }
  double sum(const Statistic& statistic, const Eigen::VectorXd& of_lines) const {
    double sum = 0;
    for (std::size_t k = 0; k < shares_.size(); ++k) sum += weights(statistic)[k] * of_lines[Eigen::Index(k)];
    return sum;
  }
  /// Encircled energies as fractions, one radius per statistic.
  Eigen::VectorXd inside(const std::vector<EncircledEnergyRadius>& circles, const Eigen::VectorXd& radius,
                         std::vector<Eigen::ArrayXd>* d_height = nullptr) {
    std::vector<Statistic> through;
    for (std::size_t j = 0; j < circles.size(); ++j)
      through.push_back(RingThrough{radius[Eigen::Index(j)], circles[j].dz});
    const Eigen::MatrixXd all = values(through, d_height);
    Eigen::VectorXd sums(radius.size());
    for (std::size_t j = 0; j < circles.size(); ++j)
      sums[Eigen::Index(j)] = sum(through[j], all.row(Eigen::Index(j)));
    return sums;
  }

 private:
  const std::vector<double>& weights(const Statistic& statistic) const {
    return kind_of(statistic).measure == Measure::kIrradiance ? irradiance_ : shares_;
  }

  const Eigen::ArrayXd& height_;
  int threads_;
  const GradientReduction& reduce_;
  std::deque<DiffractionProblem> problems_;
  std::vector<DiffractionWorkspace> own_;
  std::vector<DiffractionWorkspace*> spaces_;
  std::vector<double> shares_, irradiance_;
};

// Radii that hold the fractions of the summed energy. They lie between the smallest and the largest radius of
// the single wavelengths. All are found together by the regula falsi in the Illinois form.
Eigen::VectorXd radii_of_sum(const std::vector<EncircledEnergyRadius>& circles,
                             const Eigen::MatrixXd& of_lines, Lines* lines) {
  Eigen::VectorXd low = of_lines.rowwise().minCoeff(), high = of_lines.rowwise().maxCoeff();
  if (!of_lines.allFinite()) return Eigen::VectorXd::Constant(low.size(), std::nan(""));
  Eigen::VectorXd fraction(low.size());
  for (std::size_t j = 0; j < circles.size(); ++j) fraction[Eigen::Index(j)] = circles[j].fraction;
  Eigen::VectorXd at_low = lines->inside(circles, low) - fraction,
                  at_high = lines->inside(circles, high) - fraction, radius = low;
  Eigen::VectorXi side = Eigen::VectorXi::Zero(low.size());
  for (int step = 0; step < kMostSteps; ++step) {
    bool done = true;
    for (Eigen::Index j = 0; j < low.size(); ++j) {
      const double span = at_high[j] - at_low[j];
      radius[j] = span > 0 ? (low[j] * at_high[j] - high[j] * at_low[j]) / span : 0.5 * (low[j] + high[j]);
      radius[j] = std::clamp(radius[j], low[j], high[j]);
      done = done && high[j] - low[j] <= kSameRadius * high[j];
    }
    if (done) break;
    const Eigen::VectorXd excess = lines->inside(circles, radius) - fraction;
    bool exact = true;
    for (Eigen::Index j = 0; j < low.size(); ++j) {
      exact = exact && std::abs(excess[j]) <= kSameRadius;
      const int now = excess[j] < 0 ? -1 : 1;
      (now < 0 ? low : high)[j] = radius[j];
      (now < 0 ? at_low : at_high)[j] = excess[j];
      if (now == side[j]) (now < 0 ? at_high : at_low)[j] *= 0.5;
      side[j] = now;
    }
    if (exact) break;
  }
  return radius;
}

}  // namespace

DiffractionProblem at_line(const DiffractionProblem& problem, std::size_t k) {
  DiffractionProblem one = problem;
  one.wavelength = problem.wavelength.lines()[k].wavelength;
  if (problem.scatter) one.scatter = problem.scatter->of_line(k);
  return one;
}

bool evaluate_band(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                   const std::vector<Statistic>& statistics, int threads, DiffractionWorkspace* workspace,
                   Eigen::VectorXd* values, std::vector<Eigen::ArrayXd>* d_height,
                   const GradientReduction& reduce) {
  values->setConstant(Eigen::Index(statistics.size()), std::nan(""));
  if (d_height) d_height->assign(statistics.size(), {});
  Lines lines(problem, height, threads, workspace, reduce);
  std::vector<Statistic> sums;
  std::vector<EncircledEnergyRadius> circles;
  std::vector<std::size_t> place_of_sum, place_of_circle;
  for (std::size_t j = 0; j < statistics.size(); ++j) {
    if (const auto* circle = std::get_if<EncircledEnergyRadius>(&statistics[j])) {
      circles.push_back(*circle);
      place_of_circle.push_back(j);
    } else if (kind_of(statistics[j]).measure != Measure::kHalfWidth) {
      sums.push_back(statistics[j]);
      place_of_sum.push_back(j);
    }
  }
  std::vector<Eigen::ArrayXd> gradients;
  const Eigen::MatrixXd of_sums = lines.values(sums, d_height ? &gradients : nullptr);
  for (std::size_t j = 0; j < sums.size(); ++j) {
    (*values)[Eigen::Index(place_of_sum[j])] = lines.sum(sums[j], of_sums.row(Eigen::Index(j)));
    if (d_height) (*d_height)[place_of_sum[j]] = std::move(gradients[j]);
  }
  if (!circles.empty()) {
    const Eigen::MatrixXd of_lines = lines.values(std::vector<Statistic>(circles.begin(), circles.end()));
    const Eigen::VectorXd radius = radii_of_sum(circles, of_lines, &lines);
    for (std::size_t j = 0; j < circles.size(); ++j)
      (*values)[Eigen::Index(place_of_circle[j])] = radius[Eigen::Index(j)];
    if (d_height && radius.allFinite()) {
      const Eigen::VectorXd slope =
          ((lines.inside(circles, (1 + kStep) * radius) - lines.inside(circles, (1 - kStep) * radius))
               .array() /
           (2 * kStep * radius.array()))
              .matrix();
      lines.inside(circles, radius, &gradients);
      for (std::size_t j = 0; j < circles.size(); ++j)
        (*d_height)[place_of_circle[j]] = -gradients[j] / slope[Eigen::Index(j)];
    }
  }
  return values->allFinite();
}

}  // namespace aberfit::internal
