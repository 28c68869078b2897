# title: PSD of specification and terms
# caption: The specified two-sided 2-D power spectral density, and that of the fitted surface in bins.
#   Aberration terms carry the roughness below the cut, a scatter function that in the shaded band above it.
#   The dotted line is one cycle across the aperture.
# alt: Specified PSD over spatial frequency with the cut between terms and scatter and the PSD of the terms.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set title head('PSD of specification and terms')
eval f_axis; eval s_axis
set xlabel 'spatial frequency [cycles/mm]'; set ylabel '2-D PSD [nm² mm²]'
set key bottom left inside vertical
if (cut > 0) {
  set object 1 rectangle from first cut*1e-3, graph 0 to graph 1, graph 1 behind \
    fillcolor rgb '#f1f1f1' fillstyle solid noborder
  set arrow from first cut*1e-3, graph 0 to first cut*1e-3, graph 1 nohead linecolor rgb 'black' dashtype 2
  set label 1 'terms below '.cut_text at first cut*1e-3, graph 0.96 right offset -1,0
  set label 2 'scatter' at first cut*1e-3, graph 0.96 left offset 1,0
}
set arrow from first across*1e-3, graph 0 to first across*1e-3, graph 1 nohead linetype 1 linewidth 1
plot 'specified_psd.dat' using ($1*1e-3):($2*1e24) with lines linetype 2 title 'specification', \
  for [i=1:bins] 'specified_psd_terms.dat' using (sqrt($1*$2)*1e-3):($4*1e24):($1*1e-3):($2*1e-3) \
    with xerrorbars pointtype 7 pointsize 0.8 dashtype 1 linecolor rgb fitted_colour title 'fitted surface', \
  for [i=1:bins] 'specified_psd_terms.dat' using (sqrt($1*$2)*1e-3):($5*1e24):($6*1e24) with filledcurves \
    fillcolor rgb fitted_colour fillstyle transparent solid 0.15 noborder title '99 % of realisations'
