# title: Core of the focus
# caption: The middle of the focus, a few Airy radii wide; 1 is the peak of the ideal mirror. The dashed
#   circle is the first dark ring of the ideal mirror, 1.22 lambda f/D. Energy that roughness takes from the
#   peak is in the halo around it.
# alt: Images of the core of the focus for ideal mirror, target and fitted surface.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1500; height = 620
load 'common.gp'

set multiplot layout 1,3 title head('Core of the focus at z = f') font ',16' \
  margins screen 0.08,0.88,0.14,0.82 spacing screen 0.017,0
unset grid; unset key
set size ratio -1; set tics out
set xrange [-half*x_scale:half*x_scale]; set yrange [-half*x_scale:half*x_scale]
set logscale cb; set cbrange [faintest:1]; set format cb '%g'
set xlabel axis('x', x_unit); set ylabel axis('y', x_unit)
set cblabel 'irradiance / peak of the ideal mirror' offset 1.5,0
eval light_palette
eval pixel_axes
do for [k=1:rows] {
  set title sprintf('%s: peak %.3g', surface[k], peak[k])
  if (k > 1) { set format y ''; unset ylabel }
  if (k == rows) { set colorbox user origin screen 0.895,0.16 size screen 0.016,0.64 } else { unset colorbox }
  plot sprintf('focal_core_%s.dat', key[k]) matrix \
      using 1:2:($3/brightest) axes x2y2 with image, \
    [0:2*pi] '+' using (airy*x_scale*cos($1)):(airy*x_scale*sin($1)) with lines linecolor rgb 'white' \
      linewidth 1 dashtype 2
}
unset multiplot
