#pragma once
#include <algorithm>
#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <functional>
#include <vector>

// Generalised Harvey-Shack for a circle in any real type, written independently from PHYSICS 3 and 6. Nothing
// is interpolated and no panel adapts to the integrand.
namespace aberfit::many_digits {

template <class Real>
struct Node {
  Real x, weight;
};

/// Gauss-Legendre in `panels` equal parts of 30 nodes.
template <class Real>
std::vector<Node<Real>> nodes(const Real& a, const Real& b, int panels) {
  using Rule = boost::math::quadrature::gauss<Real, 30>;
  std::vector<Node<Real>> result;
  const Real half = (b - a) / (2 * panels);
  for (int p = 0; p < panels; ++p)
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
      for (const int sign : {-1, 1}) {
        const Real x = a + half * (2 * p + 1 + sign * Rule::abscissa()[k]);
        result.push_back({x, half * Rule::weights()[k]});
      }
  return result;
}

template <class Real>
Real pi() {
  return boost::math::constants::pi<Real>();
}

/// 1 - J0(z), accurate for small z.
template <class Real>
Real one_minus_j0(const Real& z) {
  if (z > 1) return 1 - boost::math::cyl_bessel_j(0, z);
  Real term = -1, sum = 0;
  for (int m = 1; m < 60; ++m) {
    term *= -z * z / (4 * Real(m) * m);
    sum += term;
    if (abs(term) < abs(sum) * std::numeric_limits<Real>::epsilon()) break;
  }
  return sum;
}

/// The properties of a roughness that the theory needs.
template <class Real>
struct Roughness {
  std::function<Real(const Real& x)> half_structure;  ///< C(0) - C(x) [m^2]
  Real slope_variance;                                ///< of both axes
};

/// The roughness of any S over [f_min, f_max], cut at `edges`; cycles: f_max times the largest shear.
template <class Real>
Roughness<Real> by_quadrature(const std::function<Real(const Real&)>& psd, std::vector<Real> edges,
                              double cycles) {
  std::vector<Node<Real>> weighted;  // weights of d2f S
  Real slope = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double octaves = std::log2(double(edges[i + 1] / edges[i]));
    const int panels =
        1 + int(octaves / 2) + int(cycles * double((edges[i + 1] - edges[i]) / edges.back()) / 3);
    for (const Node<Real>& w : nodes<Real>(log(edges[i]), log(edges[i + 1]), panels)) {
      const Real f = exp(w.x), mass = 2 * pi<Real>() * f * f * w.weight * psd(f);
      weighted.push_back({f, mass});
      slope += 4 * pi<Real>() * pi<Real>() * f * f * mass;
    }
  }
  return {[weighted](const Real& x) {
            Real sum = 0;
            for (const Node<Real>& node : weighted)
              sum += node.weight * one_minus_j0(Real(2 * pi<Real>() * node.x * x));
            return sum;
          },
          slope};
}

struct Scene {
  double focal_length, diameter, wavelength;
};

/// The radius with a given fraction, by Newton from `guess`. shares: the fraction and its derivative.
template <class Real, class Shares>
Real radius_of(const Shares& shares, const Real& fraction, const Real& guess) {
  Real r = guess;
  for (int i = 0; i < 40; ++i) {
    const auto [share, slope] = shares(r);
    const Real step = (share - fraction) / slope;
    r -= step;
    if (abs(step) < 1e3 * std::numeric_limits<Real>::epsilon() * r) break;
  }
  return r;
}

/// The paraxial form (textbook), over shears x = D cos(theta), for which the overlap of circles is analytic.
template <class Real>
class Paraxial {
 public:
  Paraxial(const Scene& scene, const Roughness<Real>& roughness, int panels = 5)
      : scene_(scene), half_structure_(roughness.half_structure) {
    const Real k = 4 * pi<Real>() / scene.wavelength;
    for (const Node<Real>& node : nodes<Real>(Real(0), pi<Real>() / 2, panels)) {
      const Real s = cos(node.x), less = roughness.half_structure(s * scene.diameter);
      shear_.push_back({node.x, s, node.weight * sin(node.x), exp(-k * k * less), less});
    }
    slope_variance_ = roughness.slope_variance;
  }

  Real encircled(const Real& radius, const Real& dz) const { return shares(radius, dz).first; }
  Real radius(const Real& fraction, const Real& dz, const Real& guess) const {
    return radius_of<Real>([&](const Real& r) { return shares(r, dz); }, fraction, guess);
  }
  /// Energy in a square: the mean over t of EE at side/(2 cos t), where its edge cuts circles.
  Real ensquared(const Real& side, const Real& dz) const {
    Real sum = 0;
    for (const Node<Real>& t : nodes<Real>(Real(0), pi<Real>() / 4, 1))
      sum += t.weight * encircled(side / (2 * cos(t.x)), dz);
    return 4 * sum / pi<Real>();
  }
  /// The integral of the transfer function over that of the perfect circle.
  Real strehl() const {
    Real sum = 0, perfect = 0;
    for (const Shear& one : shear_) {
      const Real of_circle = one.weight * overlap(one, 0) * one.s;
      sum += of_circle * one.transfer;
      perfect += of_circle;
    }
    return sum / perfect;
  }
  /// The transfer function at an image frequency.
  Real modulation(const Real& frequency) const {
    const Real x = frequency * scene_.wavelength * scene_.focal_length, s = x / scene_.diameter,
               k = 4 * pi<Real>() / scene_.wavelength;
    return overlap({acos(s), s, 0, 0, 0}, 0) * exp(-k * k * half_structure_(x));
  }
  /// Plane of the largest N(z) near the focus, from vertices of parabolas of width depth/50.
  Real peak_plane(const Real& ring, const Real& depth) const {
    const Real h = depth / 100;
    Real z = 0;
    for (int i = 0; i < 3; ++i) {
      const Real before = encircled(ring, z - h), here = encircled(ring, z), after = encircled(ring, z + h);
      z -= h * (after - before) / (2 * (after - 2 * here + before));
    }
    return z;
  }
  /// Plane of half that value, near `guess` on one side, by secants.
  Real half_plane(const Real& ring, const Real& guess) const {
    const Real half = encircled(ring, peak_plane(ring, guess)) / 2;
    Real a = guess, b = guess * Real(1.001), at_a = encircled(ring, a) - half;
    for (int i = 0; i < 40; ++i) {
      const Real at_b = encircled(ring, b) - half;
      if (at_b == at_a) break;
      const Real next = b - at_b * (b - a) / (at_b - at_a);
      a = b, at_a = at_b, b = next;
      if (abs(b - a) < 1e2 * std::numeric_limits<Real>::epsilon() * abs(b)) break;
    }
    return b;
  }
  /// FWHM of the line spread, near `guess`.
  Real spot_fwhm(const Real& bandwidth, const Real& guess) const {
    const Real nu = scene_.diameter / (Real(scene_.wavelength) * scene_.focal_length);
    Real w = guess * pi<Real>() * nu;
    const auto sums = [&](const Real& at) {
      std::array<Real, 2> sum{0, 0};
      for (const Shear& one : shear_) {
        const Real blur = pi<Real>() * nu * bandwidth * one.s;
        const Real t = one.weight * one.transfer * overlap(one, 0) * exp(-2 * blur * blur);
        sum[0] += t * cos(at * one.s);
        sum[1] -= t * one.s * sin(at * one.s);
      }
      return sum;
    };
    const Real half = sums(0)[0] / 2;
    for (int i = 0; i < 40; ++i) {
      const auto [value, slope] = sums(w);
      const Real step = (value - half) / slope;
      w -= step;
      if (abs(step) < 1e2 * std::numeric_limits<Real>::epsilon() * w) break;
    }
    return w / (pi<Real>() * nu);
  }
  /// RMS height about its mean over the aperture.
  Real rms_height() const {
    Real sum = 0;
    for (const Shear& one : shear_) sum += one.weight * one.less * overlap(one, 0) * one.s;
    return sqrt(8 * sum);  // 2 pi D^2/(pi D^2/4)
  }
  Real rms_slope() const { return sqrt(slope_variance_); }

 private:
  struct Shear {
    Real theta, s, weight, transfer, less;
  };
  // OTF of the circle with the phase of the defocus; u = R cos(phi) - x/2 along the shear.
  Real overlap(const Shear& one, const Real& dz) const {
    if (dz == 0) return 2 / pi<Real>() * (one.theta - sin(one.theta) * cos(one.theta));
    const Real f = scene_.focal_length, R = Real(scene_.diameter) / 2, x = 2 * R * one.s;
    const Real turn = 2 * pi<Real>() * dz / (scene_.wavelength * f * (f + dz)) * x;
    Real sum = 0;
    for (const Node<Real>& node : nodes<Real>(Real(0), one.theta, 2))
      sum += node.weight * cos(turn * (R * cos(node.x) - x / 2)) * sin(node.x) * sin(node.x);
    return 4 / pi<Real>() * sum;
  }
  std::pair<Real, Real> shares(const Real& radius, const Real& dz) const {
    const Real per_radius =
        2 * pi<Real>() * scene_.diameter / (Real(scene_.wavelength) * (scene_.focal_length + dz));
    const Real v = radius * per_radius;
    const std::vector<Real>& otf = overlaps(dz);
    Real share = 0, slope = 0;
    for (std::size_t i = 0; i < shear_.size(); ++i) {
      const Real t = shear_[i].weight * shear_[i].transfer * otf[i], z = v * shear_[i].s;
      share += t * boost::math::cyl_bessel_j(1, z);
      slope += t * shear_[i].s * boost::math::cyl_bessel_j(0, z);
    }
    return {v * share, v * slope * per_radius};
  }
  const std::vector<Real>& overlaps(const Real& dz) const {
    if (overlap_.empty() || dz_ != dz) {
      overlap_.clear();
      for (const Shear& one : shear_) overlap_.push_back(overlap(one, dz));
      dz_ = dz;
    }
    return overlap_;
  }

  Scene scene_;
  std::function<Real(const Real&)> half_structure_;
  std::vector<Shear> shear_;
  Real slope_variance_;
  mutable std::vector<Real> overlap_;
  mutable Real dz_ = 0;
};

/// Nodes between each two of `edges`, in an angle that makes square roots at the edges smooth.
template <class Real>
std::vector<Node<Real>> nodes_between(std::vector<Real> edges, int panels) {
  std::sort(edges.begin(), edges.end());
  std::vector<Node<Real>> result;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const Real half = (edges[i + 1] - edges[i]) / 2;
    if (!(half > 0)) continue;
    for (const Node<Real>& angle : nodes<Real>(Real(0), pi<Real>(), panels))
      result.push_back({edges[i] + half * (1 - cos(angle.x)), half * sin(angle.x) * angle.weight});
  }
  return result;
}

/// Overlap of an annulus with its copy at shear x, with the phase cos(turn u) along the shear, over its area.
template <class Real>
Real annulus_overlap(const Real& outer, const Real& inner, const Real& x, const Real& turn) {
  const Real end = outer - x / 2;
  std::vector<Real> edges{0, end};
  for (const Real& kink : {Real(x / 2 - inner), Real(x / 2 + inner), Real(inner - x / 2),
                           Real((outer * outer - inner * inner) / (2 * x))})
    if (kink > 0 && kink < end) edges.push_back(kink);
  const auto root = [](const Real& square) { return square > 0 ? Real(sqrt(square)) : Real(0); };
  Real sum = 0;
  for (const Node<Real>& u : nodes_between<Real>(edges, 1)) {
    const Real near = u.x - x / 2, far = u.x + x / 2;
    const Real whole = root(outer * outer - far * far);
    const Real hole = std::max(root(inner * inner - near * near), root(inner * inner - far * far));
    if (hole < whole) sum += u.weight * (whole - hole) * cos(turn * u.x);
  }
  return 4 * sum / (pi<Real>() * (outer * outer - inner * inner));
}

/// The same for a rectangle, averaged over the directions of the shear.
template <class Real>
Real rectangle_overlap(const Real& width, const Real& height, const Real& x, const Real& turn_per_shear) {
  // int cos(k a t) dt over the common |t| < (side - a)/2
  const auto along = [&](const Real& side, const Real& a) {
    const Real z = turn_per_shear * a * (side - a) / 2;
    return Real((side - a) * (abs(z) < 1e-9 ? Real(1 - z * z / 6) : Real(sin(z) / z)));
  };
  const Real from = x > width ? Real(acos(width / x)) : Real(0),
             to = x > height ? Real(asin(height / x)) : Real(pi<Real>() / 2);
  Real sum = 0;
  for (const Node<Real>& phi : nodes<Real>(from, to, 2))
    sum += phi.weight * along(width, Real(x * cos(phi.x))) * along(height, Real(x * sin(phi.x)));
  return 2 * sum / (pi<Real>() * width * height);
}

/// The paraxial form for any aperture: E(r) in any plane, from the overlap at shear x and defocus dz.
template <class Real>
class ParaxialOf {
 public:
  using Overlap = std::function<Real(const Real& x, const Real& turn_per_shear)>;
  /// edges: ends of the pieces in which the overlap is smooth, from 0 to the largest shear.
  ParaxialOf(const Scene& scene, const std::vector<Real>& edges, const Overlap& overlap, const Real& area,
             const Roughness<Real>& roughness)
      : scene_(scene), overlap_(overlap), area_(area) {
    const Real k = 4 * pi<Real>() / scene.wavelength;
    for (const Node<Real>& node : nodes_between<Real>(edges, 2)) {
      const Real less = roughness.half_structure(node.x);
      shears_.push_back({node.x, node.weight, exp(-k * k * less), less});
    }
  }
  Real encircled(const Real& radius, const Real& dz) const { return shares(radius, dz).first; }
  Real radius(const Real& fraction, const Real& dz, const Real& guess) const {
    return radius_of<Real>([&](const Real& r) { return shares(r, dz); }, fraction, guess);
  }
  Real rms_height() const {
    Real sum = 0;
    for (const Shear& one : shears_)
      sum += one.weight * one.less * overlap_(one.x, Real(0)) * 2 * pi<Real>() * one.x;
    return sqrt(sum / area_);
  }

 private:
  struct Shear {
    Real x, weight, transfer, less;
  };
  std::pair<Real, Real> shares(const Real& radius, const Real& dz) const {
    const Real f = scene_.focal_length, wave = scene_.wavelength;
    const Real per_shear = 2 * pi<Real>() / (wave * (f + dz));
    const std::vector<Real>& overlaps = overlaps_at(dz);
    Real share = 0, slope = 0;
    for (std::size_t i = 0; i < shears_.size(); ++i) {
      const Real t = shears_[i].weight * shears_[i].transfer * overlaps[i], nu = per_shear * shears_[i].x;
      share += t * boost::math::cyl_bessel_j(1, Real(nu * radius));
      slope += t * nu * boost::math::cyl_bessel_j(0, Real(nu * radius));
    }
    return {per_shear * radius * share, per_shear * radius * slope};
  }
  const std::vector<Real>& overlaps_at(const Real& dz) const {
    if (known_.empty() || dz_ != dz) {
      known_.clear();
      const Real f = scene_.focal_length, turn = 2 * pi<Real>() * dz / (scene_.wavelength * f * (f + dz));
      for (const Shear& one : shears_) known_.push_back(overlap_(one.x, turn));
      dz_ = dz;
    }
    return known_;
  }

  Scene scene_;
  Overlap overlap_;
  Real area_;
  std::vector<Shear> shears_;
  mutable std::vector<Real> known_;
  mutable Real dz_ = 0;
};

/// The aperture-exact E(r) of a parabola (PHYSICS 6) by pairs of points. variance: of the heights [m^2].
template <class Real>
class Exact {
 public:
  Exact(const Scene& scene, const Roughness<Real>& roughness, const Real& variance, const Real& dz,
        int panels = 5) {
    const Real f = scene.focal_length, t = Real(scene.diameter) / (4 * f),
               R = Real(scene.diameter) / 2 / (1 + t * t), k = 4 * pi<Real>() / scene.wavelength;
    per_radius_ = 2 * pi<Real>() * 2 * R / (Real(scene.wavelength) * (f + dz));
    const auto cosine = [&](const Real& square) { return sqrt(1 - square / (f * f)); };
    const auto amplitude = [](const Real& c) { return 2 / ((1 + c) * sqrt(c)); };
    const Real phase = 2 * pi<Real>() / scene.wavelength * dz / (1 + dz / f);
    Real all = 0;  // int |A|^2 d2P
    for (const Node<Real>& p : nodes<Real>(Real(0), R, 1)) {
      const Real a = amplitude(cosine(p.x * p.x));
      all += 2 * pi<Real>() * p.x * p.weight * a * a;
    }
    for (const Node<Real>& theta : nodes<Real>(Real(0), pi<Real>() / 2, panels)) {
      const Real x = 2 * R * cos(theta.x);
      Real sum = 0;
      for (const Node<Real>& phi : nodes<Real>(Real(0), theta.x, 1)) {
        const Real u = R * cos(phi.x) - x / 2, height = R * sin(phi.x);
        for (const Node<Real>& part : across()) {
          const Real v = height * part.x;
          const Real c1 = cosine((u + x / 2) * (u + x / 2) + v * v),
                     c2 = cosine((u - x / 2) * (u - x / 2) + v * v);
          const Real q1 = (1 + c1) / 2, q2 = (1 + c2) / 2;  // r = P/q
          const Real along = (u + x / 2) / q1 - (u - x / 2) / q2, aside = v / q1 - v / q2;
          const Real distance = sqrt(along * along + aside * aside);
          const Real h = exp(
              -k * k * (q1 * q2 * roughness.half_structure(distance) + (q1 - q2) * (q1 - q2) * variance / 2));
          sum += phi.weight * part.weight * height * R * sin(phi.x) * amplitude(c1) * amplitude(c2) *
                 cos(phase * (c2 - c1)) * h;
        }
      }
      shear_.push_back({cos(theta.x), theta.weight * sin(theta.x) * 4 * sum / all});
    }
  }
  Real radius(const Real& fraction, const Real& guess) const {
    return radius_of<Real>([&](const Real& r) { return shares(r); }, fraction, guess);
  }

 private:
  std::pair<Real, Real> shares(const Real& radius) const {
    const Real v = radius * per_radius_;
    Real share = 0, slope = 0;
    for (const Node<Real>& one : shear_) {
      share += one.weight * boost::math::cyl_bessel_j(1, Real(v * one.x));
      slope += one.weight * one.x * boost::math::cyl_bessel_j(0, Real(v * one.x));
    }
    return {v * share, v * slope * per_radius_};
  }
  // Amplitude and roughness are smooth across the shear.
  static std::vector<Node<Real>> across() {
    using Rule = boost::math::quadrature::gauss<Real, 10>;
    std::vector<Node<Real>> result;
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
      for (const int sign : {-1, 1})
        result.push_back({(1 + sign * Rule::abscissa()[k]) / 2, Rule::weights()[k] / 2});
    return result;
  }
  std::vector<Node<Real>> shear_;  // over the shear in units of the cutoff
  Real per_radius_;
};

/// dF/d ln p by sixth-order differences; the error is h^6/140 times the seventh derivative.
template <class Real, class Function>
Real log_derivative(const Function& f, const Real& step) {
  const auto difference = [&](int k) { return f(exp(k * step)) - f(exp(-k * step)); };
  return (45 * difference(1) - 9 * difference(2) + difference(3)) / (60 * step);
}

}  // namespace aberfit::many_digits
