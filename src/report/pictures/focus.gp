# title: The measured focus
# caption: Above, the measured focus and that of the fitted roughness. Below, their difference in standard
#   deviations (noise, and spread of single mirrors). If the points lie within two of zero and show no trend,
#   the roughness describes the focus.
# alt: Measured and fitted energy over radius, and the difference in standard deviations.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 900
load 'common.gp'

set multiplot
set lmargin at screen 0.12; set rmargin at screen 0.97
eval r_axis; set format x ''
set tmargin at screen 0.93; set bmargin at screen 0.36
set title head('The measured focus')
set ylabel is_image ? 'mean value of a pixel of the ring [unit of the image]' : 'encircled energy'
if (logarithmic) { set logscale y; set format y '%g' }
if (is_image) { set key inside top right vertical } else { set key inside bottom right vertical }
plot 'focus.dat' using ($1*r_scale):2:4 with yerrorbars dashtype solid pointtype 7 pointsize 0.7 \
    linecolor rgb target_colour title measured, \
  '' using ($1*r_scale):3 with lines linewidth 2 dashtype 1 linecolor rgb fitted_colour title \
      'fitted roughness'
unset title; unset logscale y; eval r_axis
set tmargin at screen 0.33; set bmargin at screen 0.09
set format '%g'; set yrange [-reach:reach]
set xlabel axis(is_image ? 'mean radius of the ring' : 'radius', r_unit)
set ylabel "measured - fitted\n[standard deviations]"
plot 0 with lines dashtype solid linecolor rgb fitted_colour notitle, \
  'focus.dat' using ($1*r_scale):5 with points pointtype 7 pointsize 0.7 linecolor rgb target_colour notitle
unset multiplot
