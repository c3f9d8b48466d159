"""Where the seconds go: plain ``mi.render`` beside uniform and adaptive sampling of ours, part by part."""
