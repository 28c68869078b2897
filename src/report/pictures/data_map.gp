# title: Measured map
# caption: Measured heights after detrending, as the PSD is estimated from them. The colours span 99.9 % of
#   the points; a spike has the last colour. A dashed line is the clear aperture.
# alt: Map of the detrended measured heights.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 1050
load 'common.gp'

set title head('Measured map, detrended')
unset key; unset grid
set xlabel axis('x', x_unit); set ylabel axis('y', x_unit)
set cblabel axis('height', h_unit).extremes offset 1.5,0
set size ratio -1; set tics out
reach_x = -1.05*x_first*x_scale; reach_y = -1.05*y_first*x_scale  # the grid's middle is 0
set cbrange [-reach*h_scale:reach*h_scale]
eval signed_palette
set xrange [-reach_x:reach_x]; set yrange [-reach_y:reach_y]
eval pixel_axes
plot name.'.dat' matrix using 1:2:($3*h_scale) axes x2y2 with image, \
  for [i=1:rims] name.'_rim.dat' index i-1 using ($1*x_scale):($2*x_scale) with lines linecolor rgb 'black' \
    linewidth 1.5 dashtype 2
