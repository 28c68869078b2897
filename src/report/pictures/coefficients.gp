# title: Coefficients of the terms
# caption: Coefficients of the fitted surface with their posterior standard deviation: Zernikes one by one and
#   summed by radial order, plane waves by frequency, spherical terms by power. Where the standard deviation
#   is as large as the value, the data do not determine that coefficient.
# alt: Coefficients of the fitted surface by Zernike index, radial order, spatial frequency and power.
# format: svg
name = ARG0[1:strlen(ARG0)-3]
load 'common.gp'

set multiplot layout rows,columns title head('Coefficients of the fitted surface') font ',16'
if (zernikes) {
  set xlabel 'Noll index j'; set xrange [first_noll-1:last_noll+1]
  if (steep) {
    set ylabel axis('size of Zernike coefficient', z_unit)
    set logscale y; set yrange [lowest*z_scale:*]; set format y '%g'
    plot 'coefficients_zernike.dat' using 1:($4 > 0 ? $4*z_scale : NaN) with points pointtype 7 \
        pointsize mark linecolor rgb target_colour title 'positive', \
      '' using 1:($4 < 0 ? -$4*z_scale : NaN) with points pointtype 7 pointsize mark \
        linecolor rgb fitted_colour title 'negative', \
      for [i=1:deviations] '' using 1:($5 > 0 ? $5*z_scale : NaN) with lines linecolor rgb 'black' \
        linewidth 1.5 dashtype 1 title 'posterior standard deviation'
  } else {
    set ylabel axis('Zernike coefficient', z_unit)
    plot for [i=1:deviations] 'coefficients_zernike.dat' using 1:(-$5*z_scale):($5*z_scale) with \
        filledcurves \
        fillcolor rgb '#d5d5d5' title 'posterior standard deviation, about zero', \
      'coefficients_zernike.dat' using 1:($4*z_scale) with impulses linecolor rgb target_colour \
        linewidth 2.1*mark dashtype 1 notitle, \
      '' using 1:($4*z_scale) with points pointtype 7 pointsize 0.8*mark linecolor rgb target_colour \
        title 'fitted value'
  }
  reset_axes = 'unset logscale; set autoscale; set xtics autofreq; set format "%g"'
  eval reset_axes
  set xlabel 'radial order n'; set xrange [first_order-1:last_order+1]
  set ylabel axis('RMS height of one order', o_unit)
  if (steep) { set logscale y } else { set yrange [0:*]; set boxwidth 0.7; set style fill solid 0.6 noborder }
  plot for [i=1:steep] 'coefficients_orders.dat' using 1:($2*o_scale) with linespoints pointtype 7 \
      pointsize 0.8 dashtype 1 linecolor rgb target_colour title 'fitted', \
    for [i=1:!steep] 'coefficients_orders.dat' using 1:($2*o_scale) with boxes linecolor rgb target_colour \
      title 'fitted', \
    for [i=1:deviations] 'coefficients_orders.dat' using 1:($3*o_scale) with linespoints pointtype 6 \
      dashtype 3 linecolor rgb fitted_colour title 'posterior standard deviation'
  eval reset_axes
}
if (waves) {
  set xlabel 'spatial frequency [cycles/m]'; set xrange [first_frequency:last_frequency]
  if (first_frequency > 0 && last_frequency > 10*first_frequency) { set logscale x }
  set ylabel axis('Fourier amplitude', f_unit); set yrange [0:*]
  plot 'coefficients_fourier.dat' using 1:($4*f_scale) with points pointtype 7 pointsize 0.6 \
      linecolor rgb target_colour title 'fitted value', \
    for [i=1:deviations] '' using 1:($5*f_scale) with points pointtype 6 pointsize 0.5 \
      linecolor rgb fitted_colour title 'posterior standard deviation'
  unset logscale; set autoscale
}
if (sphericals) {
  set xlabel 'power of rho'; set xrange [3:13]; set xtics 4,2,12
  set ylabel axis('spherical term at the rim', p_unit); set xzeroaxis linecolor rgb ideal_colour
  set boxwidth 1; set style fill solid 0.6 noborder
  plot 'coefficients_spherical.dat' using 1:($2*p_scale) with boxes linecolor rgb target_colour \
      title 'fitted value', \
    '' using 1:($2*p_scale):($3*p_scale) with yerrorbars pointtype 7 pointsize 0.6 linecolor rgb 'black' \
      title 'posterior standard deviation'
}
unset multiplot
