#pragma once
#include <complex>

namespace aberfit {

/// Forward transform sum_jk values(j, k) exp(-2 pi i (j r/rows + k c/columns)) of a rows x columns array (row
/// after row), in place, unnormalised; rows = 1 for one dimension. Any size; safe to call from many threads
/// at once; the same bits every time.
void fourier_transform(int rows, int columns, std::complex<double>* values);

}  // namespace aberfit
