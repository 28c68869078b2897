# title: Fitted surface
# caption: Height of the aberration terms over the aperture, seen from the side of the incoming light: red is
#   too high, blue too low. Roughness that is left to scatter is not included.
# alt: Map of the height of the fitted surface over the aperture.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 1050
load 'common.gp'

set title head('Fitted surface error')
unset key; unset grid
set xlabel axis('x', x_unit); set ylabel axis('y', x_unit)
set cblabel axis('height', h_unit).', towards the light   (RMS '.rms.', peak to valley '.peak_to_valley.')' \
  offset 1.5,0
set size ratio -1; set tics out
set xrange [-x_reach*x_scale:x_reach*x_scale]; set yrange [-y_reach*x_scale:y_reach*x_scale]
set cbrange [-largest*h_scale:largest*h_scale]
eval signed_palette
eval pixel_axes
plot 'surface.dat' matrix using 1:2:($3*h_scale) axes x2y2 with image, \
  for [i=1:rims] 'surface_rim.dat' index i-1 using ($1*x_scale):($2*x_scale) with lines \
    linecolor rgb 'black' linewidth 1.5 dashtype 2
