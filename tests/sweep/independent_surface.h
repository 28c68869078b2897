#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "aberfit/scene/mirror.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Height of a term surface above the parabola of its mirror, written anew for the tests. It shares only the
/// definition of the terms with the library. Zernikes are by Jacobi polynomials, the conic by the difference
/// of both sags in a form without cancellation.
class IndependentSurface {
 public:
  IndependentSurface(const Mirror& mirror, const TermSet& terms, const Eigen::VectorXd& coefficients);

  /// Height [m], towards the light, without the offsets of segments.
  double height(double x, double y) const;
  /// Offset of the segment that holds a point [m]; 0 outside all segments.
  double step(double x, double y) const;
  bool has_steps() const { return !steps_.empty(); }
  /// Slopes of the height, by fourth-order differences whose error is 1e-8 of the finest term's slopes at
  /// most.
  std::array<double, 2> slopes(double x, double y) const;
  /// Cost of one height: the number of sines, cosines and steps of recurrences.
  double cost() const { return cost_; }

 private:
  // Terms of one azimuthal order: weights of cos and sin by (n - m)/2.
  struct Order {
    int m = 0;
    std::vector<double> cosine, sine;
  };
  struct Zernikes {
    double radius = 0;
    std::vector<Order> orders;
    void add(const ZernikeMode& mode, double value);
    double height(double x, double y) const;
  };
  struct Wave {
    double fx, fy, cosine, sine;
  };
  struct Power {
    int power;
    double value;  // at the rim
  };
  struct Step {
    Outline outline;
    double x, y, reach2, piston, slope_x, slope_y;
  };

  Mirror mirror_;
  double radius_;
  std::vector<Step> steps_;
  Zernikes terms_, known_;
  std::vector<Wave> waves_;
  std::vector<Power> powers_;
  double step_ = 0, cost_ = 0;
};

}  // namespace aberfit
