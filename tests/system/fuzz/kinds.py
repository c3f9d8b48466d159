"""All kinds of inputs: a name, and a function of a random generator and a folder that returns a command line.

The function writes what it likes into the folder; results go to the folder ``out`` beside it.
"""

from . import (
    checkpoint_inputs,
    light_inputs,
    mesh_inputs,
    option_inputs,
    part_inputs,
    picture_inputs,
    scene_inputs,
    volume_inputs,
)

KINDS = {
    "cut short": scene_inputs.cut_short,
    "flipped bytes": scene_inputs.flipped_bytes,
    "moved text": scene_inputs.moved_text,
    "elements": scene_inputs.changed_elements,
    "values": scene_inputs.changed_values,
    "references": part_inputs.references,
    "nothing much": part_inputs.nothing_much,
    "films": part_inputs.films,
    "lights": light_inputs.lights,
    "materials": light_inputs.materials,
    "transforms": light_inputs.transforms,
    "damaged meshes": mesh_inputs.damaged_meshes,
    "lying meshes": mesh_inputs.lying_meshes,
    "odd meshes": mesh_inputs.odd_meshes,
    "textures": picture_inputs.textures,
    "importance": picture_inputs.importance,
    "scores": picture_inputs.scores,
    "volumes": volume_inputs.volumes,
    "spectra": volume_inputs.spectra,
    "radiosity": part_inputs.radiosity,
    "resumed": checkpoint_inputs.resumed,
    "merged": checkpoint_inputs.merged,
    "options": option_inputs.options,
    "configurations": option_inputs.configurations,
}
