# title: Slopes of the fitted surface
# caption: Left, the distribution of slopes, weighted by energy, with Gaussians of the same width. Right, the
#   slopes themselves with ellipses of 1, 2 and 3 standard deviations. A rough surface has Gaussian slopes,
#   alike in x and y.
# alt: Densities of the slopes along x and y, and a cloud of both.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1500; height = 840
load 'common.gp'

set multiplot title head('Slopes of the fitted surface') font ',16'
set samples 401
set xrange [-reach*s_scale:reach*s_scale]
set lmargin at screen 0.075; set rmargin at screen 0.52
set bmargin at screen 0.11; set tmargin at screen 0.80
set xlabel axis('slope of the surface', s_unit); set ylabel 'density [1/'.s_unit.']'
set yrange [0:*]; set offsets 0,0,graph 0.1,0
set key at screen 0.3,0.935 center top vertical maxrows 2 width -2
if (strlen(specified)) { set label 1 specified at graph 0.02,0.96 }
gauss(t, s) = exp(-0.5*t*t/(s*s)) / (s*sqrt(2*pi))
plot 'gradients.dat' using ($1*s_scale):($2/s_scale) with histeps linecolor rgb target_colour linewidth 2 \
    dashtype 1 title 'dh/dx, RMS '.rms_x, \
  gauss(x/s_scale - mean_x, sigma_x)/s_scale with lines linecolor rgb target_colour linewidth 1.5 dashtype 2 \
    title 'Gaussian', \
  'gradients.dat' using ($1*s_scale):($3/s_scale) with histeps linecolor rgb fitted_colour linewidth 2 \
    dashtype 1 title 'dh/dy, RMS '.rms_y, \
  gauss(x/s_scale - mean_y, sigma_y)/s_scale with lines linecolor rgb fitted_colour linewidth 1.5 dashtype 2 \
    title 'Gaussian'
unset label; unset offsets
set lmargin at screen 0.62; set rmargin at screen 0.99
set size ratio -1; set samples 181
set yrange [-reach*s_scale:reach*s_scale]
set xlabel axis('dh/dx', s_unit); set ylabel axis('dh/dy', s_unit)
set key at screen 0.8,0.935 center top vertical maxrows 2
plot 'gradients_scatter.dat' using ($1*s_scale):($2*s_scale) with points pointtype 7 pointsize 0.3 \
    linecolor rgb target_colour title points, \
  for [k=1:3] [0:2*pi] '+' using ((mean_x + k*sigma_x*cos($1))*s_scale):((mean_y + \
      k*sigma_y*sin($1))*s_scale) \
    with lines linecolor rgb 'black' linewidth 1.2 dashtype k title sprintf('%d sigma', k)
unset multiplot
