#include "segment_terms.h"

namespace aberfit::internal {

using Eigen::Index;

SegmentTerms::SegmentTerms(const TermSet& terms, const PupilSample& points)
    : begin_(terms.segments_begin()),
      each_(terms.of_a_segment()),
      piston_(terms.segments->piston() > 0),
      first_(std::size_t(points.size())),
      u_(points.size()),
      v_(points.size()),
      per_radius_(points.size()) {
  for (Index i = 0; i < points.size(); ++i) {
    const double x = points.x[i], y = points.y[i];
    const std::size_t number =
        points.segment.empty() ? terms.segments->at(x, y) : points.segment[std::size_t(i)];
    const Segments::Segment& segment = terms.segments->all()[number];
    first_[std::size_t(i)] = begin_ + Index(number) * each_;
    per_radius_[i] = 1 / segment.radius;
    u_[i] = (x - segment.centre[0]) / segment.radius;
    v_[i] = (y - segment.centre[1]) / segment.radius;
  }
}

SegmentTerms::AtPoint SegmentTerms::at(Index point) const {
  const double u = u_[point], v = v_[point], slope = per_radius_[point];
  if (!piston_) return {{u, v, 0}, {slope, 0, 0}, {0, slope, 0}};
  return {{1, u, v}, {0, slope, 0}, {0, 0, slope}};
}

void SegmentTerms::forward(const Eigen::VectorXd& coefficients, int, bool add, SurfaceField* field) const {
  if (!add)
    for (Eigen::ArrayXd* plane : {&field->height, &field->slope_x, &field->slope_y}) plane->setZero();
  for (Index i = 0; i < u_.size(); ++i) {
    const AtPoint terms = at(i);
    const double* const c = coefficients.data() + first_[std::size_t(i)];
    for (std::size_t k = 0; k < std::size_t(each_); ++k) {
      field->height[i] += c[k] * terms.height[k];
      field->slope_x[i] += c[k] * terms.slope_x[k];
      field->slope_y[i] += c[k] * terms.slope_y[k];
    }
  }
}

void SegmentTerms::adjoint(const SurfaceField& weights, int, Eigen::VectorXd* sums) const {
  sums->tail(sums->size() - begin_).setZero();
  for (Index i = 0; i < u_.size(); ++i) {
    const AtPoint terms = at(i);
    double* const c = sums->data() + first_[std::size_t(i)];
    for (std::size_t k = 0; k < std::size_t(each_); ++k)
      c[k] += weights.height[i] * terms.height[k] + weights.slope_x[i] * terms.slope_x[k] +
              weights.slope_y[i] * terms.slope_y[k];
  }
}

void SegmentTerms::add_heights(const Eigen::ArrayXd& weights, Eigen::Ref<Eigen::VectorXd> sums) const {
  for (Index i = 0; i < u_.size(); ++i) {
    const AtPoint terms = at(i);
    double* const c = sums.data() + first_[std::size_t(i)];
    for (std::size_t k = 0; k < std::size_t(each_); ++k) c[k] += weights[i] * terms.height[k];
  }
}

}  // namespace aberfit::internal
