# title: Deflections of the rays
# caption: Angle between each ray and that of the ideal mirror: along x, y and z, and its magnitude.
#   Harvey-Shack takes them from Gaussians, so that the magnitude follows Rayleigh's law. The terms of one
#   realisation come close to these laws if the surface has enough independent patches.
# alt: Histograms of deflections for Harvey-Shack and aberration terms with the laws they follow.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1400; height = 1100
load 'common.gp'

set multiplot layout 2,2 title head('Deflections of the rays') font ',16'
set key inside top right vertical Right noreverse
arcsec = 180*3600/pi
array what[4] = ['deflection along x', 'deflection along y', 'change of the direction cosine z', 'magnitude']
do for [k=1:4] {
  d = d_scale[k]
  set xlabel axis(what[k], d_unit[k]); set ylabel 'density [1/'.d_unit[k].']'
  set xrange [low[k]*d:high[k]*d]; set yrange [0:*]; set offsets 0,0,graph 0.3,0
  law = k < 4 ? sprintf('Gaussian, std %.4g %s', sigma[k]*d, d_unit[k]) : 'Rayleigh'
  if (k == 4) {
    set x2range [low[k]*arcsec:high[k]*arcsec]; set x2tics; set x2label 'scatter angle [arcsec]'
    set arrow from mean*d, graph 0 to mean*d, graph 0.7 nohead linecolor rgb 'black' linewidth 1.2 dashtype 2
    set arrow from rms*d, graph 0 to rms*d, graph 0.7 nohead linecolor rgb 'black' linewidth 1.2 dashtype 3
  }
  plot 'deflections.dat' index k-1 using ($1*d):($2/d) with histeps linecolor rgb target_colour linewidth 2 \
      dashtype 1 title 'Harvey-Shack', \
    '' index k-1 using ($1*d):($3/d) with lines linetype 1 title law, \
    '' index k-1 using ($1*d):($4/d) with histeps linecolor rgb fitted_colour linewidth 1.2 dashtype 1 \
      title 'terms, one realisation', \
    for [i=4:k] NaN with lines linecolor rgb 'black' linewidth 1.2 dashtype 2 \
      title sprintf('mean %.4g %s', mean*d, d_unit[k]), \
    for [i=4:k] NaN with lines linecolor rgb 'black' linewidth 1.2 dashtype 3 \
      title sprintf('RMS %.4g %s', rms*d, d_unit[k])
}
unset multiplot
