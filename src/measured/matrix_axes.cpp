#include "matrix_axes.h"

#include <cmath>

namespace aberfit::internal {
namespace {

// Returns the step of evenly ascending or descending numbers, rounded in the file; otherwise 0.
double even_step(const std::vector<double>& numbers) {
  constexpr double kUneven = 0.05;
  if (numbers.size() < kLeastOnAxis) return 0;
  const double step = (numbers.back() - numbers.front()) / double(numbers.size() - 1);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!(std::abs(numbers[i] - numbers.front() - double(i) * step) <= kUneven * std::abs(step))) return 0;
  return step;
}

bool same_step(double a, double b) {
  constexpr double kSame = 0.05;
  return std::abs(a - b) <= kSame * std::abs(a);
}

std::vector<double> behind_corner(const std::vector<double>& row) { return {row.begin() + 1, row.end()}; }

std::vector<double> column_behind_corner(const std::vector<std::vector<double>>& rows, std::size_t column) {
  std::vector<double> numbers;
  for (std::size_t row = 1; row < rows.size(); ++row) numbers.push_back(rows[row][column]);
  return numbers;
}

}  // namespace

bool has_axes(const std::vector<std::vector<double>>& rows) {
  if (rows.size() < kLeastOnAxis + 1 || rows.front().size() < kLeastOnAxis + 1) return false;
  for (const std::vector<double>& row : rows)
    if (row.size() != rows.front().size()) return false;
  const double along_row = even_step(behind_corner(rows[0])), down = even_step(column_behind_corner(rows, 0));
  if (along_row == 0 || down == 0) return false;
  return !same_step(along_row, even_step(behind_corner(rows[1]))) ||
         !same_step(down, even_step(column_behind_corner(rows, 1)));
}

}  // namespace aberfit::internal
