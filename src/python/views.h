#pragma once
#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <memory>

namespace aberfit::internal {

/// A NumPy array over numbers that `owner` keeps alive; nothing is copied. Only a single owner may let it be
/// written to.
template <typename Derived>
pybind11::array view(const Eigen::DenseBase<Derived>& numbers, std::shared_ptr<const void> owner,
                     bool writeable = false) {
  using Scalar = typename Derived::Scalar;
  const auto& plain = numbers.derived();
  constexpr pybind11::ssize_t kSize = sizeof(Scalar);
  auto kept = std::make_unique<std::shared_ptr<const void>>(std::move(owner));
  const pybind11::capsule base(
      kept.get(), [](void* pointer) { delete static_cast<std::shared_ptr<const void>*>(pointer); });
  kept.release();
  const bool is_vector = Derived::ColsAtCompileTime == 1;
  const std::vector<pybind11::ssize_t> shape =
      is_vector ? std::vector<pybind11::ssize_t>{plain.rows()}
                : std::vector<pybind11::ssize_t>{plain.rows(), plain.cols()};
  const std::vector<pybind11::ssize_t> strides =
      is_vector ? std::vector<pybind11::ssize_t>{kSize}
                : std::vector<pybind11::ssize_t>{kSize * plain.rowStride(), kSize * plain.colStride()};
  pybind11::array result(pybind11::dtype::of<Scalar>(), shape, strides, plain.data(), base);
  if (!writeable) result.attr("flags").attr("writeable") = false;
  return result;
}

/// A NumPy array that owns `numbers`.
template <typename Plain>
pybind11::array owned(Plain numbers) {
  const auto kept = std::make_shared<Plain>(std::move(numbers));
  return view(*kept, kept, true);
}

}  // namespace aberfit::internal
