# title: Cuts through the vertex
# caption: Height of the fitted surface along two lines through the vertex, and below it the slope along these
#   lines.
# alt: Height and slope of the fitted surface along x and along y.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 900
load 'common.gp'

set xrange [-radius*x_scale:radius*x_scale]
set lmargin 11; set rmargin 3
set xzeroaxis linecolor rgb ideal_colour linewidth 1
set multiplot title head('Cuts through the vertex') font ',16'
set size 1,0.49; set origin 0,0.46
set format x ''; set ylabel axis('height', h_unit)
plot 'profile.dat' using ($1*x_scale):($2*h_scale) with lines linetype 2 title 'along x (y = 0)', \
  '' using ($1*x_scale):($3*h_scale) with lines linetype 3 title 'along y (x = 0)'
set size 1,0.48; set origin 0,0
set format x '%g'; set xlabel axis('distance from the vertex', x_unit)
set ylabel axis('slope along the cut', s_unit)
plot 'profile.dat' using ($1*x_scale):($4*s_scale) with lines linetype 2 title 'dh/dx along x', \
  '' using ($1*x_scale):($5*s_scale) with lines linetype 3 title 'dh/dy along y'
unset multiplot
