# title: Spots near focus
# caption: Irradiance in three planes on one logarithmic scale. The dashed circle holds 90 % of the target's
#   energy at z = f. Target and fitted surface have the same spread of energy, but the target is a smooth mean
#   over mirrors, and one mirror has speckle.
# alt: Images of the irradiance before, at and behind the focus, one row each for ideal mirror, target and
#   fitted surface.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1500
load 'common.gp'

bottom = 85.0/height; top = 1 - 90.0/height
set multiplot layout rows,3 title head('Spots near focus') font ',16' \
  margins screen 0.08,0.88,bottom,top spacing screen 0.017,45.0/height
unset grid; unset key
set size ratio -1; set tics out
set xrange [-half*x_scale:half*x_scale]; set yrange [-half*x_scale:half*x_scale]
set logscale cb; set cbrange [faintest:brightest]; set format cb '%.0e'
set cblabel 'fraction of the energy per pixel   (dashed: ee90 at z = f)' offset 1.5,0
eval light_palette
eval pixel_axes
do for [row=1:rows] {
  do for [column=1:3] {
    if (row == 1) { set title plane[column] offset 0,-0.5 } else { unset title }
    if (row == rows) { set format x '%g'; set xlabel axis('x', x_unit) } else { set format x ''; unset \
        xlabel }
    if (column == 1) { set format y '%g'; set ylabel surface[row].'      '.axis('y', x_unit) } \
    else { set format y ''; unset ylabel }
    if (row == 1 && column == 3) {
      set colorbox user origin screen 0.895,bottom size screen 0.016,top-bottom
    } else { unset colorbox }
    plot sprintf('focal_images_%s_%s.dat', key[row], word('before focus behind', column)) matrix \
        using 1:2:3 axes x2y2 with image notitle, \
      for [i=1:ring < half] [0:2*pi] '+' using (ring*x_scale*cos($1)):(ring*x_scale*sin($1)) with lines \
        linecolor rgb 'white' linewidth 1 dashtype 2 notitle
  }
}
unset multiplot
