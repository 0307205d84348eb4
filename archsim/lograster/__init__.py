"""Rasterization on a uniform or a logarithmic grid of rows, tile by tile. [Lloyd07] sec. 4"""
