// Compares two-dimensional transforms, by the library's kernels and by FFTW, with direct sums.
#include "aberfit/roughness/fourier_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"

namespace aberfit {
namespace {

// The sizes include one short side and one with a prime above 7; few are multiples of eight.
TEST(FourierTransform, IsItsSum) {
  for (const auto& [rows, columns] : {std::pair{64, 96}, {70, 135}, {105, 64}, {63, 64}, {64, 66}, {1, 90}}) {
    const RandomStream stream(5, "fourier-transform");
    std::vector<std::complex<double>> field(std::size_t(rows * columns));
    for (std::size_t k = 0; k < field.size(); ++k)
      field[k] = {stream.normal(2 * k), stream.normal(2 * k + 1)};
    std::vector<std::complex<double>> transformed = field;
    const FourierTransform transform(rows, columns);
    transform(transformed.data());
    for (const auto& [r, c] :
         {std::pair{0, 0}, {rows - 1, 1}, {rows / 3, columns / 2}, {rows / 2, columns - 1}}) {
      std::complex<double> sum = 0;
      for (int j = 0; j < rows; ++j)
        for (int k = 0; k < columns; ++k)
          sum += field[std::size_t(j * columns + k)] *
                 std::polar(1.0, -2 * std::numbers::pi *
                                     (double(j * r % rows) / rows + double(k * c % columns) / columns));
      EXPECT_LT(std::abs(transformed[std::size_t(r * columns + c)] - sum),
                1e-14 * std::sqrt(double(field.size())) * 20)
          << rows << " x " << columns << " at " << r << ", " << c;
    }
  }
}

}  // namespace
}  // namespace aberfit
