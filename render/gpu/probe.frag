#version 460
#extension GL_EXT_multiview : require
layout(location = 0) out vec4 colour;
void main() { colour = vec4(float(gl_ViewIndex + 1) / 2.0); }
