# title: Map, terms and residual
# caption: The measured map without piston and tilt, the terms fitted to it, and the residual. The first two
#   have the same colours; the residual has its own. Single outliers have the last colour.
# alt: Height maps of measurement, fitted terms and residual side by side.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1800; height = 640
load 'common.gp'

set multiplot title head('Measured map without piston and tilt, its terms, and the residual') font ',16'
unset key; unset grid
set size ratio -1; set tics out
eval signed_palette
set xlabel 'x [mm]'; set ylabel 'y [mm]'
set xrange [(x_first - x_pitch)*x_scale:(x_last + x_pitch)*x_scale]
set yrange [(y_first - y_pitch)*x_scale:(y_last + y_pitch)*x_scale]
eval pixel_axes
set bmargin at screen 0.13; set tmargin at screen 0.85
array left[3] = [0.065, 0.335, 0.685]
do for [k=1:3] {
  set lmargin at screen left[k]; set rmargin at screen left[k] + 0.235
  set title label[k]
  if (k > 1) { set format y ''; unset ylabel; unset colorbox }
  set cbrange [-reach[k]*1e9:reach[k]*1e9]
  if (k == 1) { unset colorbox } else {
    set colorbox user origin screen left[k] + 0.243,0.16 size screen 0.012,0.66
    set cblabel (k == 2 ? 'height of both [nm], colours span 99.9 %' : 'height [nm], colours span 99.9 %') \
        offset 1,0
  }
  plot 'map_heights_'.word('measured fitted residual', k).'.dat' matrix \
    using 1:2:($3*1e9) axes x2y2 with image
}
unset multiplot
