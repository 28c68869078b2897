# title: Height of the terms
# caption: Height error of the aberration terms of one realisation along two lines through the vertex.
# alt: Height of the aberration terms along x and along y.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 700
load 'common.gp'

set title head('Height error of the aberration terms')
set xlabel axis('distance from the vertex', x_unit); set ylabel axis('height', h_unit)
set xrange [-radius*x_scale:radius*x_scale]; set offsets 0,0,graph 0.15,0
set key inside top right vertical
set label 1 'RMS over the aperture '.rms.(halved ? ', half the specified one (convention paper)' : '') \
  at graph 0.02,0.95
plot 'height_profile.dat' using ($1*x_scale):($2*h_scale) with lines linetype 2 title 'along x (y = 0)', \
  '' using ($1*x_scale):($3*h_scale) with lines linetype 3 title 'along y (x = 0)'
