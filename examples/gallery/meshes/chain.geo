// gmsh -3 -format msh22 chain.geo; in chain.msh, coordinates are rounded to 6 digits
// a quarter of a chain of round wire (radius w, bends of radius R about the wire's middle): half a link, a link at right angles, half a link
w = 2; R = 5; s = 1; h = 2.4; f = 0.38;
Point(1) = {R, 0, 0, h}; Point(2) = {R + w, 0, 0, h}; Point(3) = {R, 0, w, h}; Point(4) = {R - w, 0, 0, f};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 1}; Line(4) = {1, 2};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
a[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi/2} { Surface{1}; };
b[] = Extrude {-s, 0, 0} { Surface{a[0]}; };
Physical Volume("link 1") = {a[1], b[1]}; Physical Surface("held") = {b[0]}; Physical Surface("bend 1") = {a[2], a[3]};
Physical Surface("middle 1") = {a[4], a[5], b[4], b[5]}; Physical Surface("end 1") = {1};

Point(101) = {1, 0, 0, h}; Point(102) = {1 - w, 0, 0, h}; Point(103) = {1, w, 0, h}; Point(104) = {1 + w, 0, 0, f};
Circle(101) = {102, 101, 103}; Circle(102) = {103, 101, 104}; Line(103) = {104, 101}; Line(104) = {101, 102};
Curve Loop(101) = {101:104}; Plane Surface(101) = {101};
c[] = Extrude {{0, 1, 0}, {1 + R, 0, 0}, Pi/2} { Surface{101}; };
d[] = Extrude {2 * s, 0, 0} { Surface{c[0]}; };
e[] = Extrude {{0, 1, 0}, {1 + R + 2 * s, 0, 0}, Pi/2} { Surface{d[0]}; };
Physical Volume("link 2") = {c[1], d[1], e[1]}; Physical Surface("left bend") = {c[2], c[3]}; Physical Surface("right bend") = {e[2], e[3]};
Physical Surface("middle 2") = {c[4], c[5], d[4], d[5], e[4], e[5]}; Physical Surface("end 2") = {101, e[0]};

x = 2 + R + 2 * s;
Point(201) = {x, 0, 0, h}; Point(202) = {x - w, 0, 0, h}; Point(203) = {x, 0, w, h}; Point(204) = {x + w, 0, 0, f};
Circle(201) = {202, 201, 203}; Circle(202) = {203, 201, 204}; Line(203) = {204, 201}; Line(204) = {201, 202};
Curve Loop(201) = {201:204}; Plane Surface(201) = {201};
p[] = Extrude {{0, 0, 1}, {x + R, 0, 0}, -Pi/2} { Surface{201}; };
q[] = Extrude {s, 0, 0} { Surface{p[0]}; };
Physical Volume("link 3") = {p[1], q[1]}; Physical Surface("pulled") = {q[0]}; Physical Surface("bend 3") = {p[2], p[3]};
Physical Surface("middle 3") = {p[4], p[5], q[4], q[5]}; Physical Surface("end 3") = {201};
