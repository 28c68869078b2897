# title: PSF of the map
# caption: Above, the PSF of the measured map, of its terms alone, and of the terms with the residual as
#   scatter. Circles hold 80 % of the energy; dashed ones have the width of the spot. Below, the encircled
#   energies and that of the perfect mirror.
# alt: Diffraction images of the map, its terms and terms with residual PSD, and encircled energy over
#   radius.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1500
load 'common.gp'

set multiplot title head('PSF of the map (circles: ee80; dashed: FWHM)') font ',16'
if (images) {
  half = -x_first
  unset key; unset grid
  set size ratio -1; set tics out
  set xrange [-half*x_scale:half*x_scale]; set yrange [-half*x_scale:half*x_scale]
  set logscale cb; set cbrange [faintest:1]; set format cb '%.0e'
  set cblabel "irradiance / peak of the perfect mirror" offset 1,0
  eval light_palette
  set xlabel axis('x', x_unit); set ylabel axis('y', x_unit)
  set bmargin at screen 0.52; set tmargin at screen 0.90
  eval pixel_axes
  do for [number in lit] {
    k = number+0
    set lmargin at screen 0.07 + 0.285*(k-1); set rmargin at screen 0.33 + 0.285*(k-1)
    if (k > 1) { set format y ''; unset ylabel }
    if (k < 3) { unset colorbox } else { set colorbox user origin screen 0.908,0.54 size screen 0.014,0.34 }
    set title image_title[k]
    plot 'map_light_'.word('measured terms terms_and_residual_psd', k).'.dat' matrix \
        using 1:2:3 axes x2y2 with image, \
      for [i=1:fwhm[k] < 2*half] [0:2*pi] '+' \
        using (0.5*fwhm[k]*x_scale*cos($1)):(0.5*fwhm[k]*x_scale*sin($1)) with lines linecolor rgb 'white' \
        linewidth 1.2 dashtype (4,4), \
      for [i=1:ee80[k] < half] [0:2*pi] '+' using (ee80[k]*x_scale*cos($1)):(ee80[k]*x_scale*sin($1)) \
        with lines linecolor rgb 'white' linewidth 1.2 dashtype 1
  }
}
unset link x2; unset link y2; set autoscale
set linetype 4 linecolor rgb good_colour linewidth 2.5 dashtype (4,4)
set lmargin at screen 0.07; set rmargin at screen 0.97
set bmargin at screen (images ? 0.07 : 0.12); set tmargin at screen (images ? 0.43 : 0.88)
unset title; set size noratio; set grid
set xrange [0:last*x_scale]; set yrange [0:1.05]; set ytics 0.2; set format y '%g'
set xlabel axis('radius', x_unit); set ylabel 'encircled energy'
set key bottom right inside vertical maxcols 1 Left reverse
plot for [k in curves] 'map_light.dat' using ($1*x_scale):(column(k+1)) with lines \
  linetype int(word('2 3 4 1', k+0)) title label[k+0]
unset multiplot
